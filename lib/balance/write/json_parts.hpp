#pragma once
/// Pieces that several JSON documents share. Private to the writers: it knows the JSON library.

#include "balance/motion/motion.hpp"
#include "balance/study/result.hpp"
#include "balance/study/study.hpp"
#include "balance/write/conditions_view.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace balance {

/// Keeps the order in which keys are written.
using Json = nlohmann::ordered_json;

/// Two spaces deep, ending with a line feed. What is not finite is null.
std::string dump(const Json& value);

Json vector_json(const Vector3& vector, int axes);
Json numbers_json(const VectorX& numbers);
Json metric_json(const Metric& metric);
Json outcome_json(const MotionOutcome& outcome);

/// One name, or a list if there are several.
Json goals_json(const std::vector<Goal>& goals);

/// Text, LaTeX, terms, residual, … of every condition.
Json conditions_list_json(const ConditionsView& view);

/// Rank, gap and singular values, the parameters' names, the symbols, the conditions and the notes, added to an object.
void add_conditions(Json& json, const ConditionsView& view);

}  // namespace balance
