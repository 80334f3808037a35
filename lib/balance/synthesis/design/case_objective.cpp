#include "balance/synthesis/design/case_objective.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/required_motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace balance {

namespace {

/// Where a case's parameters and springs stand among those of all cases side by side.
struct CaseOffsets {
  std::vector<int> parameters;
  FreeSprings loose;
};

std::vector<CaseOffsets> case_offsets(const CaseSpace& space, const FreeSprings& loose) {
  // every list is one case after the other; parameters go by bearers of one sort, cases within them
  std::vector<CaseOffsets> places;
  std::vector<std::vector<Parameter>> lists;
  std::size_t spring = 0;
  for (const DesignSpace& one : space.cases) {
    CaseOffsets place;
    const std::size_t springs = one.start.mechanism.springs.size();
    for (std::size_t s = 0; s < springs && !loose.empty(); ++s) place.loose.push_back(loose[spring + s]);
    spring += springs;
    lists.push_back(list_parameters(one.start.mechanism, place.loose));
    place.parameters.resize(lists.back().size());
    places.push_back(std::move(place));
  }
  int next = 0;
  for (const ParameterOwner bearer :
       {ParameterOwner::body, ParameterOwner::attachment, ParameterOwner::disc, ParameterOwner::spring})
    for (std::size_t k = 0; k < lists.size(); ++k)
      for (std::size_t p = 0; p < lists[k].size(); ++p)
        if (lists[k][p].owner_kind == bearer) places[k].parameters[p] = next++;
  return places;
}

Eigen::Index count_parameters(const std::vector<CaseOffsets>& places) {
  Eigen::Index total = 0;
  for (const CaseOffsets& place : places) total += static_cast<Eigen::Index>(place.parameters.size());
  return total;
}

/// What of the cases' values counts.
enum class CaseReduction { largest, mean, least };

CaseReduction case_reduction(CaseAggregation across) {
  return across == CaseAggregation::mean ? CaseReduction::mean : CaseReduction::largest;
}

class CaseObjectives {
 public:
  CaseObjectives(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseReduction counts,
                 const FreeSprings& loose)
      : space_(space), counts_(counts), places_(case_offsets(space, loose)) {
    for (std::size_t k = 0; k < space.cases.size(); ++k)
      each_.push_back(build_objective(space.cases[k], terms, space.values(k, space.start_values()), places_[k].loose));
  }

  const std::vector<Objective>& each() const { return each_; }

  double of_parameters(const VectorX& parameters, VectorX* gradient) const {
    VectorX values(size()), own;
    if (gradient != nullptr) gradient->setZero(parameters.size());
    std::vector<VectorX> slopes(each_.size());
    for (std::size_t k = 0; k < each_.size(); ++k)
      values[static_cast<Eigen::Index>(k)] =
          each_[k].of_parameters(parameters(places_[k].parameters), gradient != nullptr ? &slopes[k] : nullptr);
    const Eigen::Index worst = counts_ == CaseReduction::least ? min_index(values) : max_index(values);
    for (std::size_t k = 0; k < slopes.size() && gradient != nullptr; ++k)
      if (counts_ == CaseReduction::mean)
        (*gradient)(places_[k].parameters) += slopes[k] / static_cast<double>(size());
      else if (static_cast<Eigen::Index>(k) == worst)
        (*gradient)(places_[k].parameters) = slopes[k];
    return reduce(values);
  }

  double of_variables(const VectorX& x) const {
    VectorX values(size());
    for (std::size_t k = 0; k < each_.size(); ++k) {
      const VectorX own = space_.values(k, x);
      values[static_cast<Eigen::Index>(k)] =
          each_[k].of_variables
              ? each_[k].of_variables(own)
              : each_[k].of_parameters(
                    parameter_values(instantiate_checked(space_.cases[k], own).mechanism, places_[k].loose), nullptr);
    }
    return reduce(values);
  }

  std::string failure_reason(const VectorX& x) const {
    for (std::size_t k = 0; k < each_.size(); ++k)
      if (const std::string why = each_[k].failure_reason(space_.values(k, x)); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(each_.size()); }
  double reduce(const VectorX& values) const {
    if (!values.allFinite()) return NAN;
    if (counts_ == CaseReduction::mean) return values.mean();
    return counts_ == CaseReduction::least ? min_coefficient(values) : max_coefficient(values);
  }

  CaseSpace space_;
  CaseReduction counts_;
  std::vector<CaseOffsets> places_;
  std::vector<Objective> each_;
};

/// The figure of one case as one of all parameters.
AffineFigure expand_to_all_cases(AffineFigure figure, const CaseOffsets& place, Eigen::Index total) {
  if (figure.coefficients.size() > 0) {
    const VectorX own = figure.coefficients;
    figure.coefficients.setZero(total);
    figure.coefficients(place.parameters) = own;
  }
  for (AffineSeries& series : figure.series) {
    const MatrixX own = series.rows;
    series.rows.setZero(own.rows(), total + 1);
    series.rows(Eigen::all, place.parameters) = own.leftCols(own.cols() - 1);
    series.rows.col(total) = own.rightCols(1);
  }
  return figure;
}

using Figures = std::optional<std::vector<AffineFigure>>;

/// A sum of parameters that is never negative, as the peak of a series of one sample.
void make_series(AffineFigure& figure) {
  if (figure.coefficients.size() == 0) return;
  AffineSeries one;
  one.rows.setZero(1, figure.coefficients.size() + 1);
  one.rows.leftCols(figure.coefficients.size()) = figure.coefficients.transpose();
  one.components = 1;
  one.time_weights = VectorX::Ones(1);
  figure = {figure.weight, {}, Statistic::peak, {std::move(one)}};
}

/// The worst of one figure is one figure again: the worst of all series counts.
Figures combine_case_figures(std::vector<std::vector<AffineFigure>> each, CaseAggregation across) {
  std::vector<AffineFigure> all;
  const double share = across == CaseAggregation::mean ? 1.0 / static_cast<double>(each.size()) : 1;
  for (std::vector<AffineFigure>& figures : each)
    for (AffineFigure& figure : figures) {
      if (across == CaseAggregation::worst) make_series(figure);
      if (across == CaseAggregation::worst && !all.empty()) {
        std::move(figure.series.begin(), figure.series.end(), std::back_inserter(all.front().series));
        continue;
      }
      figure.weight *= share;
      all.push_back(std::move(figure));
    }
  return all;
}

}  // namespace

namespace {

Objective build_reduced_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseReduction counts,
                                  const FreeSprings& loose) {
  const auto cases = std::make_shared<const CaseObjectives>(space, terms, counts, loose);
  const std::vector<Objective>& each = cases->each();
  const auto all = [&](auto&& holds) { return std::all_of(each.begin(), each.end(), holds); };
  Objective objective;
  objective.name =
      each.front().name + (counts == CaseReduction::mean ? " on average over the cases" : " in the worst case");
  objective.unit = each.front().unit;
  objective.is_convex = all([](const Objective& one) { return one.is_convex; });
  objective.is_secondary = all([](const Objective& one) { return one.is_secondary; });
  objective.lower_bound = each.front().lower_bound;
  if (all([](const Objective& one) { return bool(one.of_parameters); }))
    objective.of_parameters = [cases](const VectorX& p, VectorX* gradient) {
      return cases->of_parameters(p, gradient);
    };
  else
    objective.of_variables = [cases](const VectorX& x) { return cases->of_variables(x); };
  objective.failure_reason = [cases](const VectorX& x) { return cases->failure_reason(x); };
  return objective;
}

}  // namespace

Objective build_case_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseAggregation across,
                               const FreeSprings& loose) {
  return build_reduced_objective(space, terms, case_reduction(across), loose);
}

std::vector<DesignLimit> build_case_limits(const CaseSpace& space, const std::vector<FigureLimit>& limits,
                                           const FreeSprings& loose) {
  std::vector<DesignLimit> built;
  for (const FigureLimit& limit : limits)
    built.push_back(
        {limit.text,
         build_reduced_objective(space, limit.terms,
                                 limit.is_lower ? CaseReduction::least : case_reduction(limit.aggregation), loose),
         limit.is_lower, limit.bound});
  return built;
}

namespace {

using Bounded = std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)>;

/// One limit in every case.
struct CaseLimit {
  CaseAggregation across;
  std::vector<Bounded> each;
};

/// Limits on means add up to one, of all cases' figures; those on the worst value are as many as cases.
void add_limit(std::vector<ConvexLimit> each, CaseAggregation across, std::vector<ConvexLimit>& all) {
  if (across == CaseAggregation::worst) {
    std::move(each.begin(), each.end(), std::back_inserter(all));
    return;
  }
  ConvexLimit mean{{}, each.front().bound};
  for (ConvexLimit& own : each)
    for (AffineFigure& figure : own.figures) {
      figure.weight /= static_cast<double>(each.size());
      mean.figures.push_back(std::move(figure));
    }
  all.push_back(std::move(mean));
}

}  // namespace

Bounded build_case_convex_limits(const CaseSpace& space, const std::vector<FigureLimit>& limits,
                                 const FreeSprings& loose, int& known) {
  const std::vector<CaseOffsets> places = case_offsets(space, loose);
  std::vector<CaseLimit> built;
  for (const FigureLimit& limit : limits) {
    CaseLimit one{limit.aggregation, {}};
    int is_known = 0;
    for (std::size_t k = 0; k < space.cases.size(); ++k)
      one.each.push_back(build_convex_limits(space.cases[k], {limit}, places[k].loose, is_known));
    if (is_known > 0) built.push_back(std::move(one));
  }
  known = static_cast<int>(built.size());
  if (built.empty()) return {};
  return [space, built, places,
          total = count_parameters(places)](const VectorX& x) -> std::optional<std::vector<ConvexLimit>> {
    std::vector<ConvexLimit> all;
    for (const CaseLimit& limit : built) {
      std::vector<ConvexLimit> each;
      for (std::size_t k = 0; k < limit.each.size(); ++k) {
        auto own = limit.each[k](space.values(k, x));
        if (!own) return std::nullopt;
        for (AffineFigure& figure : own->front().figures)
          figure = expand_to_all_cases(std::move(figure), places[k], total);
        each.push_back(std::move(own->front()));
      }
      add_limit(std::move(each), limit.across, all);
    }
    return all;
  };
}

std::function<Figures(const VectorX& x)> build_case_convex_terms(const CaseSpace& space,
                                                                 const std::vector<ObjectiveTerm>& terms,
                                                                 CaseAggregation across, const FreeSprings& loose,
                                                                 FigureSampling samples) {
  if (across == CaseAggregation::worst && terms.size() > 1) return {};
  const std::vector<CaseOffsets> places = case_offsets(space, loose);
  const Eigen::Index total = count_parameters(places);
  std::vector<std::function<Figures(const VectorX&)>> each;
  for (std::size_t k = 0; k < space.cases.size(); ++k) {
    each.push_back(build_convex_terms(space.cases[k], terms, places[k].loose, samples));
    if (!each.back()) return {};
  }
  return [space, each, places, total, across](const VectorX& x) -> Figures {
    std::vector<std::vector<AffineFigure>> found;
    for (std::size_t k = 0; k < each.size(); ++k) {
      Figures own = each[k](space.values(k, x));
      if (!own) return std::nullopt;
      for (AffineFigure& figure : *own) figure = expand_to_all_cases(std::move(figure), places[k], total);
      found.push_back(std::move(*own));
    }
    return combine_case_figures(std::move(found), across);
  };
}

VectorX CaseSpace::values(std::size_t which, const VectorX& x) const { return x(variable_index[which]); }

VectorX CaseSpace::start_values() const {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) x[static_cast<Eigen::Index>(i)] = numbers[i].start;
  return x;
}

CaseSpace CaseSpace::fix_others(const VectorX& x, const std::vector<int>& kept) const {
  CaseSpace part;
  for (const int i : kept) {
    part.numbers.push_back(numbers[static_cast<std::size_t>(i)]);
    part.numbers.back().start = x[i];
  }
  for (std::size_t k = 0; k < cases.size(); ++k) {
    std::vector<int> own, place;
    for (std::size_t i = 0; i < variable_index[k].size(); ++i) {
      const auto at = std::find(kept.begin(), kept.end(), variable_index[k][i]);
      if (at == kept.end()) continue;
      own.push_back(static_cast<int>(i));
      place.push_back(static_cast<int>(at - kept.begin()));
    }
    part.cases.push_back(cases[k].fix_others(values(k, x), own));
    part.variable_index.push_back(std::move(place));
  }
  return part;
}

CaseSpace make_case_space(const DesignSpace& space) {
  const LoadCases& loads = space.start.design.cases;
  const auto& free = space.start.free_numbers;
  const auto adapted = [&](std::size_t i) {
    return std::find(loads.adapted.begin(), loads.adapted.end(), static_cast<int>(i)) != loads.adapted.end();
  };
  CaseSpace whole;
  std::vector<int> shared(free.size(), -1);
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (adapted(i)) continue;
    shared[i] = static_cast<int>(whole.numbers.size());
    whole.numbers.push_back(free[i]);
  }
  for (Eigen::Index k = 0; k < loads.size(); ++k) {
    const VectorX load = loads.values.row(k);
    whole.cases.push_back(at_load(space, load));
    whole.variable_index.push_back(shared);
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (!adapted(i)) continue;
      whole.variable_index.back()[i] = static_cast<int>(whole.numbers.size());
      whole.numbers.push_back(free[i]);
      whole.numbers.back().key_path += fmt::format(" ({})", load_text(loads.numbers, load));
    }
  }
  return whole;
}

DesignSpace at_load(const DesignSpace& space, const VectorX& loads) {
  DesignSpace loaded = space;
  const auto& numbers = space.start.design.cases.numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    loaded.inputs[static_cast<std::size_t>(numbers[i].input)] = loads[static_cast<Eigen::Index>(i)];
  loaded.start = loaded.study_at(space.start_values());
  return loaded;
}

VectorX nominal_load(const DesignSpace& space) {
  const auto& numbers = space.start.design.cases.numbers;
  VectorX loads(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) loads[static_cast<Eigen::Index>(i)] = numbers[i].nominal;
  return loads;
}

std::string load_text(const std::vector<LoadParameter>& numbers, const VectorX& loads) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    text += fmt::format("{}{} = {:.6g}", i == 0 ? "" : ", ", numbers[i].name,
                        loads[static_cast<Eigen::Index>(i)] / numbers[i].unit);
  return text;
}

}  // namespace balance
