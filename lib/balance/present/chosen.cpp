#include "balance/present/chosen.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {

namespace {

std::vector<std::string> names_of(const DesignReport& report, std::size_t choice, bool kept) {
  std::vector<std::string> names;
  const std::vector<bool>& all = report.outcome.chosen->kept[choice];
  for (std::size_t k = 0; k < all.size(); ++k)
    if (all[k] == kept) names.push_back(report.choices[choice].elements[k].name);
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

std::string chosen_text(const DesignReport& report) {
  if (!report.outcome.chosen) return "";
  std::string text;
  for (std::size_t c = 0; c < report.choices.size(); ++c)
    text += fmt::format("{}: {}, {}\n", report.choices[c].kind, sentence(names_of(report, c, true), "kept"),
                        sentence(names_of(report, c, false), "left out"));
  if (report.outcome.chosen->least >= 0)
    text += fmt::format("fewest: {} of them are enough, {}\n", report.outcome.chosen->least,
                        report.outcome.chosen->least_proved ? "and it is proved that fewer are not"
                                                            : "but it is not shown that fewer are not");
  return text;
}

Json chosen_json(const DesignReport& report) {
  if (!report.outcome.chosen) return nullptr;
  const ChosenElements& chosen = *report.outcome.chosen;
  Json choices = Json::array();
  for (std::size_t c = 0; c < report.choices.size(); ++c)
    choices.push_back({{"section", report.choices[c].kind},
                       {"most", report.choices[c].most < 0 ? Json("least") : Json(report.choices[c].most)},
                       {"kept", names_of(report, c, true)},
                       {"left_out", names_of(report, c, false)}});
  return {{"choices", std::move(choices)},
          {"least", chosen.least < 0 ? Json(nullptr) : Json(chosen.least)},
          {"least_proved", chosen.least < 0 ? Json(nullptr) : Json(chosen.least_proved)}};
}

std::vector<OfferedElement> left_out(const DesignReport& report) {
  std::vector<OfferedElement> all;
  if (!report.outcome.chosen) return all;
  for (std::size_t c = 0; c < report.choices.size(); ++c)
    for (const std::string& name : names_of(report, c, false))
      for (const OfferedElement& one : report.study_before.design.choose[c].from)
        if (one.name == name) all.push_back(one);
  return all;
}

}  // namespace balance
