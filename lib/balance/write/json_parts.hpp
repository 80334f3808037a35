#pragma once
/// Pieces that several JSON documents share. Private to the writers: it knows the JSON library.

#include "balance/motion/motion.hpp"
#include "balance/result/result.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace balance {

/// Keeps the order in which keys are written.
using Json = nlohmann::ordered_json;

/// Two spaces deep, ending with a line feed. What is not finite is null.
std::string format_json(const Json& value);

Json vector_json(const Vector3& vector, int axes);
Json numbers_json(const VectorX& numbers);
Json metric_json(const Metric& metric);
Json outcome_json(const MotionOutcome& outcome);

}  // namespace balance
