#include "balance/synthesis/design/case_conditions.hpp"

#include "balance/synthesis/conditions/known_terms.hpp"
#include "balance/synthesis/conditions/modular_conditions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace balance::design {

namespace {

using dynamics::ParameterOwner;

/// Rows [first, last) of a case's conditions.
struct RowRange {
  std::size_t case_index;
  Eigen::Index first, last;
};

class CaseConditions {
 public:
  CaseConditions(const Mechanism& united, const Mechanism& one, std::size_t cases, const std::vector<Goal>& goals,
                 const ConditionOptions& options, bool is_modular)
      : united_(united), one_(one), case_count_(cases), options_(options), is_modular_(is_modular) {
    out_.goals = goals;
    out_.parameters = conditions::list_terms(united, options.loose_springs);
    out_.known_term_values = conditions::known_term_values(united);
    out_.variable_terms = options.variable_terms;
  }

  Conditions run() {
    out_.status = ConditionsStatus::done;
    for (std::size_t k = 0; k < case_count_; ++k) {
      cases_.push_back(derive(extract_part(united_, one_, k), k));
      if (cases_.back().status != ConditionsStatus::done) {
        out_.status = cases_.back().status;
        out_.reason = fmt::format("in case {}, {}", k + 1, cases_.back().reason);
        return std::move(out_);
      }
      add_figures(cases_.back());
    }
    stack();
    return std::move(out_);
  }

 private:
  static std::vector<bool> slice_of(const std::vector<bool>& all, std::size_t size, std::size_t k) {
    if (all.empty()) return {};
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(k * size);
    return {begin, begin + static_cast<std::ptrdiff_t>(size)};
  }

  /// Terms of all loads come before those of all friction, and these before those of all force elements.
  std::vector<bool> variable_terms_of(const std::vector<dynamics::Parameter>& known, std::size_t k) const {
    std::vector<bool> variable;
    if (options_.variable_terms.empty()) return variable;
    auto begin = options_.variable_terms.begin();
    for (const ParameterOwner owner : {ParameterOwner::load, ParameterOwner::friction, ParameterOwner::force_element}) {
      const auto count = static_cast<std::size_t>(
          std::count_if(known.begin(), known.end(), [&](const auto& term) { return term.owner_kind == owner; }));
      const auto end = begin + static_cast<std::ptrdiff_t>(count * case_count_);
      const std::vector<bool> slice = slice_of({begin, end}, count, k);
      variable.insert(variable.end(), slice.begin(), slice.end());
      begin = end;
    }
    return variable;
  }

  Conditions derive(const Mechanism& part, std::size_t k) const {
    ConditionOptions options = options_;
    options.loose_springs = slice_of(options_.loose_springs, part.springs.size(), k);
    options.variable_terms = variable_terms_of(conditions::list_known_terms(part), k);
    return is_modular_ ? conditions::derive_modular_conditions(part, out_.goals, options)
                       : conditions::derive_conditions(part, out_.goals, options);
  }

  /// The singular values of all cases are those with the smallest gap.
  void add_figures(const Conditions& one) {
    if (cases_.size() == 1) {
      out_.min_kept_singular_value = one.min_kept_singular_value;
      out_.max_dropped_singular_value = one.max_dropped_singular_value;
      out_.singular_value_gap = one.singular_value_gap;
    }
    out_.min_kept_singular_value = std::min(out_.min_kept_singular_value, one.min_kept_singular_value);
    out_.max_dropped_singular_value = std::max(out_.max_dropped_singular_value, one.max_dropped_singular_value);
    out_.singular_value_gap = std::min(out_.singular_value_gap, one.singular_value_gap);
    out_.rank += one.rank;
    out_.samples += one.samples;
    for (const std::string& note : one.notes)
      if (std::find(out_.notes.begin(), out_.notes.end(), note) == out_.notes.end()) out_.notes.push_back(note);
  }

  /// Rows that contain known terms alone come last.
  void stack() {
    std::vector<std::vector<dynamics::Parameter>> terms;
    for (const Conditions& one : cases_) terms.push_back(one.parameters);
    const std::vector<std::vector<int>> columns = list_case_columns(terms);
    std::vector<RowRange> ranges;
    Eigen::Index rows = 0;
    for (std::size_t k = 0; k < cases_.size(); ++k) ranges.push_back({k, 0, cases_[k].parameter_rows()});
    for (std::size_t k = 0; k < cases_.size(); ++k)
      ranges.push_back({k, cases_[k].parameter_rows(), cases_[k].matrix.rows()});
    for (const RowRange& range : ranges) rows += range.last - range.first;
    out_.matrix.setZero(rows, static_cast<Eigen::Index>(out_.parameters.size()));
    out_.row_scales.resize(rows);
    Eigen::Index next = 0;
    for (const RowRange& range : ranges) {
      const Conditions& one = cases_[range.case_index];
      for (Eigen::Index r = range.first; r < range.last; ++r, ++next) {
        out_.matrix.row(next)(columns[range.case_index]) = one.matrix.row(r);
        out_.row_scales[next] = one.row_scales[r];
        out_.pivots.push_back(
            columns[range.case_index][static_cast<std::size_t>(one.pivots[static_cast<std::size_t>(r)])]);
      }
    }
  }

  const Mechanism& united_;
  const Mechanism& one_;
  std::size_t case_count_;
  const ConditionOptions& options_;
  bool is_modular_;
  std::vector<Conditions> cases_;
  Conditions out_;
};

}  // namespace

std::vector<std::vector<int>> list_case_columns(const std::vector<std::vector<dynamics::Parameter>>& terms) {
  std::vector<std::vector<int>> columns(terms.size());
  for (std::size_t k = 0; k < terms.size(); ++k) columns[k].resize(terms[k].size());
  int next = 0;
  for (const ParameterOwner owner :
       {ParameterOwner::body, ParameterOwner::attachment, ParameterOwner::disc, ParameterOwner::spring,
        ParameterOwner::load, ParameterOwner::friction, ParameterOwner::force_element})
    for (std::size_t k = 0; k < terms.size(); ++k)
      for (std::size_t p = 0; p < terms[k].size(); ++p)
        if (terms[k][p].owner_kind == owner) columns[k][p] = next++;
  return columns;
}

Conditions derive_case_conditions(const Mechanism& united, const Mechanism& one, std::size_t cases,
                                  const std::vector<Goal>& goals, const ConditionOptions& options, bool is_modular) {
  return CaseConditions(united, one, cases, goals, options, is_modular).run();
}

}  // namespace balance::design
