#include "balance/synthesis/design/case_conditions.hpp"

#include "balance/synthesis/conditions/known_terms.hpp"
#include "balance/synthesis/conditions/modular_conditions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>

namespace balance::design {

namespace {

using dynamics::ParameterOwner;

/// Takes one mechanism after the other out of a disjoint union of mechanisms whose lists have the same lengths.
class CaseExtraction {
 public:
  CaseExtraction(const Mechanism& united, const Mechanism& one) : united_(united), one_(one) {}

  std::size_t count() const { return (united_.bodies.size() - 1) / (one_.bodies.size() - 1); }

  Mechanism extract(std::size_t k) const {
    const int body_offset = static_cast<int>(k * (one_.bodies.size() - 1)),
              coordinate_offset = static_cast<int>(k * one_.coordinates.size());
    const auto shift_body = [&](BodyId& body) {
      if (body != model::ground) body = BodyId(body - body_offset);
    };
    const auto shift_leaders = [&](model::CoordinateCombination& combination) {
      for (model::CoordinateTerm& term : combination.terms) term.coordinate += -coordinate_offset;
    };
    const auto slice = [&](auto Mechanism::*list, const auto& shift) {
      const auto size = static_cast<std::ptrdiff_t>((united_.*list).size() / count());
      const auto begin = (united_.*list).begin() + static_cast<std::ptrdiff_t>(k) * size;
      auto items = std::decay_t<decltype(united_.*list)>(begin, begin + size);
      for (auto& item : items) shift(item);
      return items;
    };
    Mechanism part = one_;
    for (std::size_t b = 1; b < one_.bodies.size(); ++b)
      part.bodies[b] = united_.bodies[b + k * (one_.bodies.size() - 1)];
    part.joints = slice(&Mechanism::joints, [&](Joint& joint) { shift_body(joint.first), shift_body(joint.second); });
    part.couplings = slice(&Mechanism::couplings, [&](Coupling& coupling) {
      coupling.follower += -coordinate_offset;
      shift_leaders(coupling.leader);
    });
    part.constraints = slice(&Mechanism::constraints, [&](model::GeneralisedSpeed& speed) {
      for (model::GeneralisedSpeedTerm& term : speed.terms) {
        shift_body(term.body);
        if (term.kind == model::GeneralisedSpeedTerm::Kind::coordinate) term.index -= coordinate_offset;
      }
    });
    part.attachments = slice(&Mechanism::attachments, [&](Attachment& attachment) { shift_body(attachment.body); });
    part.discs = slice(&Mechanism::discs, [&](Disc& disc) {
      shift_body(disc.body);
      shift_leaders(disc.follows);
    });
    part.loads = slice(&Mechanism::loads, [&](Load& load) { shift_body(load.body); });
    part.springs = slice(&Mechanism::springs, [&](Spring& spring) {
      shift_body(spring.first), shift_body(spring.second);
      if (spring.is_joint_spring()) spring.coordinate += -coordinate_offset;
    });
    part.friction = slice(&Mechanism::friction, [&](Friction& friction) { friction.coordinate += -coordinate_offset; });
    part.assembly =
        slice(&Mechanism::assembly, [&](CoordinateValue& value) { value.coordinate += -coordinate_offset; });
    part.tool = united_.tool;  // of the first case, and what a mechanism carries does not move its tool
    return part;
  }

 private:
  const Mechanism& united_;
  const Mechanism& one_;
};

/// Per case, the columns of its terms among those of all cases: first by kind of owner, then by case.
std::vector<std::vector<int>> list_case_columns(const std::vector<std::vector<dynamics::Parameter>>& terms) {
  std::vector<std::vector<int>> columns(terms.size());
  for (std::size_t k = 0; k < terms.size(); ++k) columns[k].resize(terms[k].size());
  int next = 0;
  for (const ParameterOwner owner : {ParameterOwner::body, ParameterOwner::attachment, ParameterOwner::disc,
                                     ParameterOwner::spring, ParameterOwner::load, ParameterOwner::friction})
    for (std::size_t k = 0; k < terms.size(); ++k)
      for (std::size_t p = 0; p < terms[k].size(); ++p)
        if (terms[k][p].owner_kind == owner) columns[k][p] = next++;
  return columns;
}

/// Rows [first, last) of a case's conditions.
struct RowRange {
  std::size_t case_index;
  Eigen::Index first, last;
};

class CaseConditions {
 public:
  CaseConditions(const Mechanism& united, const Mechanism& one, const std::vector<Goal>& goals,
                 const ConditionOptions& options)
      : extraction_(united, one), options_(options) {
    out_.goals = goals;
    out_.parameters = conditions::list_terms(united, options.loose_springs);
    out_.known_term_values = conditions::known_term_values(united);
    out_.variable_terms = options.variable_terms;
  }

  Conditions run() {
    out_.status = ConditionsStatus::done;
    std::vector<std::vector<dynamics::Parameter>> terms;
    for (std::size_t k = 0; k < extraction_.count(); ++k) {
      const Mechanism part = extraction_.extract(k);
      const dynamics::FreeSprings loose = slice_of(options_.loose_springs, part.springs.size(), k);
      terms.push_back(conditions::list_terms(part, loose));
      cases_.push_back(derive(part, loose, k));
      if (cases_.back().status != ConditionsStatus::done) {
        out_.status = cases_.back().status;
        out_.reason = fmt::format("in case {}, {}", k + 1, cases_.back().reason);
        return std::move(out_);
      }
      add_figures(cases_.back());
    }
    stack(list_case_columns(terms));
    return std::move(out_);
  }

 private:
  static std::vector<bool> slice_of(const std::vector<bool>& all, std::size_t size, std::size_t k) {
    if (all.empty()) return {};
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(k * size);
    return {begin, begin + static_cast<std::ptrdiff_t>(size)};
  }

  Conditions derive(const Mechanism& part, const dynamics::FreeSprings& loose, std::size_t k) const {
    ConditionOptions options = options_;
    options.loose_springs = loose;
    // Terms of all loads come before those of all friction.
    const std::vector<dynamics::Parameter> known = conditions::list_known_terms(part);
    const auto loads = static_cast<std::size_t>(std::count_if(
        known.begin(), known.end(), [](const auto& term) { return term.owner_kind == ParameterOwner::load; }));
    if (!options_.variable_terms.empty()) {
      const auto split = options_.variable_terms.begin() + static_cast<std::ptrdiff_t>(loads * extraction_.count());
      options.variable_terms = slice_of({options_.variable_terms.begin(), split}, loads, k);
      const std::vector<bool> friction = slice_of({split, options_.variable_terms.end()}, known.size() - loads, k);
      options.variable_terms.insert(options.variable_terms.end(), friction.begin(), friction.end());
    }
    return conditions::derive_modular_conditions(part, out_.goals, options);
  }

  void add_figures(const Conditions& one) {
    const bool is_first = cases_.size() == 1;
    const auto keep = [&](double Conditions::*figure, bool is_smaller_better) {
      double& value = out_.*figure;
      value = is_first ? one.*figure : is_smaller_better ? std::max(value, one.*figure) : std::min(value, one.*figure);
    };
    keep(&Conditions::min_kept_singular_value, false);
    keep(&Conditions::max_dropped_singular_value, true);
    keep(&Conditions::singular_value_gap, false);
    out_.rank += one.rank;
    out_.samples += one.samples;
    for (const std::string& note : one.notes)
      if (std::find(out_.notes.begin(), out_.notes.end(), note) == out_.notes.end()) out_.notes.push_back(note);
  }

  /// Rows that contain known terms alone come last.
  void stack(const std::vector<std::vector<int>>& columns) {
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

  CaseExtraction extraction_;
  const ConditionOptions& options_;
  std::vector<Conditions> cases_;
  Conditions out_;
};

}  // namespace

Conditions derive_modular_case_conditions(const Mechanism& united, const Mechanism& one, const std::vector<Goal>& goals,
                                          const ConditionOptions& options) {
  return CaseConditions(united, one, goals, options).run();
}

}  // namespace balance::design
