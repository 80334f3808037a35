#include "balance/present/chosen.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {

namespace {

std::vector<std::string> names_of(const DesignReport& report, std::size_t choice, bool kept) {
  std::vector<std::string> names;
  const std::vector<bool>& all = report.outcome.selection->kept[choice];
  for (std::size_t k = 0; k < all.size(); ++k)
    if (all[k] == kept) names.push_back(report.cardinality_constraints[choice].elements[k].name);
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::string sentence(const std::vector<std::string>& names, const char* what) {
  if (names.empty()) return std::string("none is ") + what;
  return fmt::format("{} {} {}", joined(names), names.size() == 1 ? "is" : "are", what);
}

}  // namespace

std::string format_optional_elements(const DesignReport& report) {
  if (!report.outcome.selection) return "";
  std::string text;
  for (std::size_t c = 0; c < report.cardinality_constraints.size(); ++c)
    text += fmt::format("{}: {}, {}\n", report.cardinality_constraints[c].kind,
                        sentence(names_of(report, c, true), "kept"), sentence(names_of(report, c, false), "left out"));
  if (report.outcome.selection->min_count >= 0)
    text += fmt::format("fewest: {} of them are enough, {}\n", report.outcome.selection->min_count,
                        report.outcome.selection->is_min_count_proved ? "and it is proved that fewer are not"
                                                                      : "but it is not shown that fewer are not");
  return text;
}

Json optional_elements_json(const DesignReport& report) {
  if (!report.outcome.selection) return nullptr;
  const ElementSelection& chosen = *report.outcome.selection;
  Json choices = Json::array();
  for (std::size_t c = 0; c < report.cardinality_constraints.size(); ++c)
    choices.push_back(
        {{"section", report.cardinality_constraints[c].kind},
         {"most", report.cardinality_constraints[c].max_count < 0 ? Json("least")
                                                                  : Json(report.cardinality_constraints[c].max_count)},
         {"kept", names_of(report, c, true)},
         {"left_out", names_of(report, c, false)}});
  return {{"choices", std::move(choices)},
          {"least", chosen.min_count < 0 ? Json(nullptr) : Json(chosen.min_count)},
          {"least_proved", chosen.min_count < 0 ? Json(nullptr) : Json(chosen.is_min_count_proved)}};
}

std::vector<OptionalElementText> list_omitted_elements(const DesignReport& report) {
  std::vector<OptionalElementText> all;
  if (!report.outcome.selection) return all;
  for (std::size_t c = 0; c < report.cardinality_constraints.size(); ++c)
    for (const std::string& name : names_of(report, c, false))
      for (const OptionalElementText& one : report.study_before.design.cardinality[c].elements)
        if (one.name == name) all.push_back(one);
  return all;
}

}  // namespace balance
