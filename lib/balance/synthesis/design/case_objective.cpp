#include "balance/synthesis/design/case_objective.hpp"

#include "balance/synthesis/design/case_conditions.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/required_motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::design {

using study::CaseAggregation;

namespace {

std::vector<CaseOffsets> case_offsets(const CaseSpace& space, const dynamics::FreeSprings& loose) {
  std::vector<CaseOffsets> offsets;
  std::vector<std::vector<dynamics::Parameter>> lists;
  std::size_t spring = 0;
  for (const DesignSpace& one : space.cases) {
    CaseOffsets offset;
    const std::size_t springs = one.start.mechanism.springs.size();
    for (std::size_t s = 0; s < springs && !loose.empty(); ++s) offset.loose.push_back(loose[spring + s]);
    spring += springs;
    lists.push_back(dynamics::list_parameters(one.start.mechanism, offset.loose));
    offsets.push_back(std::move(offset));
  }
  std::vector<std::vector<int>> columns = list_case_columns(lists);
  for (std::size_t k = 0; k < offsets.size(); ++k) offsets[k].parameters = std::move(columns[k]);
  return offsets;
}

Eigen::Index count_parameters(const std::vector<CaseOffsets>& offsets) {
  Eigen::Index total = 0;
  for (const CaseOffsets& offset : offsets) total += static_cast<Eigen::Index>(offset.parameters.size());
  return total;
}

/// How the values of the cases are combined.
enum class CaseReduction { max, mean, min };

CaseReduction case_reduction(CaseAggregation across) {
  return across == CaseAggregation::mean ? CaseReduction::mean : CaseReduction::max;
}

/// An objective combined over all cases.
class CaseFunction final : public DesignFunction {
 public:
  CaseFunction(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseReduction reduction,
               const dynamics::FreeSprings& loose, MotionCache& cache)
      : space_(space),
        reduction_(reduction),
        term_count_(terms.size()),
        is_range_(terms.front().size == ObjectiveTerm::Size::none && terms.front().figure == Statistic::range),
        offsets_(case_offsets(space, loose)) {
    for (std::size_t k = 0; k < space.cases.size(); ++k)
      case_objectives_.push_back(
          build_objective(space.cases[k], terms, space.values(k, space.start_values()), offsets_[k].loose, cache));
  }

  const std::vector<Objective>& case_objectives() const { return case_objectives_; }

  Domain domain() const override {
    const bool is_parametric = std::all_of(case_objectives_.begin(), case_objectives_.end(),
                                           [](const Objective& one) { return one.is_of_parameters(); });
    return is_parametric ? Domain::parameters : Domain::variables;
  }
  double evaluate(const VectorX& at, VectorX* gradient) const override {
    return domain() == Domain::parameters ? evaluate_parameters(at, gradient) : evaluate_variables(at);
  }
  /// The worst of several maxima is one maximum, but the worst of sums of maxima is none.
  bool has_max_terms() const override {
    const bool is_single = term_count_ == 1 && !is_range_;
    return (reduction_ == CaseReduction::mean || (reduction_ == CaseReduction::max && is_single)) &&
           std::all_of(case_objectives_.begin(), case_objectives_.end(),
                       [](const Objective& one) { return one.function->has_max_terms(); });
  }
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& x) const override {
    std::vector<MaxTerm> all;
    for (std::size_t k = 0; k < case_objectives_.size(); ++k) {
      std::optional<std::vector<MaxTerm>> terms = case_objectives_[k].function->max_terms(space_.values(k, x));
      if (!terms) return std::nullopt;
      for (MaxTerm& term : *terms) {
        const MatrixX own = term.jacobian;
        term.jacobian.setZero(own.rows(), x.size());
        term.jacobian(Eigen::all, space_.variable_index[k]) = own;
        if (reduction_ == CaseReduction::mean) term.weight /= static_cast<double>(size());
        if (reduction_ == CaseReduction::mean || all.empty())
          all.push_back(std::move(term));
        else
          append(term, all.front());
      }
    }
    return all;
  }
  /// Of the worst case, if the cases have no common maximum.
  std::optional<VectorX> gradient(const VectorX& x) const override {
    if (has_max_terms()) return max_term_gradient(max_terms(x), x.size());
    if (reduction_ == CaseReduction::mean || domain() == Domain::parameters) return std::nullopt;
    const VectorX values = case_values(x);
    if (!values.allFinite()) return std::nullopt;
    const auto worst = static_cast<std::size_t>(reduction_ == CaseReduction::min ? numerics::min_index(values)
                                                                                 : numerics::max_index(values));
    const std::optional<VectorX> own = case_objectives_[worst].function->gradient(space_.values(worst, x));
    if (!own) return std::nullopt;
    VectorX gradient = VectorX::Zero(x.size());
    gradient(space_.variable_index[worst]) = *own;
    return gradient;
  }
  std::string failure_reason(const VectorX& x) const override {
    for (std::size_t k = 0; k < case_objectives_.size(); ++k)
      if (const std::string why = case_objectives_[k].function->failure_reason(space_.values(k, x)); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }

 private:
  double evaluate_parameters(const VectorX& parameters, VectorX* gradient) const {
    VectorX values(size());
    if (gradient != nullptr) gradient->setZero(parameters.size());
    std::vector<VectorX> slopes(case_objectives_.size());
    for (std::size_t k = 0; k < case_objectives_.size(); ++k)
      values[static_cast<Eigen::Index>(k)] = case_objectives_[k].function->evaluate(
          parameters(offsets_[k].parameters), gradient != nullptr ? &slopes[k] : nullptr);
    const Eigen::Index worst =
        reduction_ == CaseReduction::min ? numerics::min_index(values) : numerics::max_index(values);
    for (std::size_t k = 0; k < slopes.size() && gradient != nullptr; ++k)
      if (reduction_ == CaseReduction::mean)
        (*gradient)(offsets_[k].parameters) += slopes[k] / static_cast<double>(size());
      else if (static_cast<Eigen::Index>(k) == worst)
        (*gradient)(offsets_[k].parameters) = slopes[k];
    return reduce(values);
  }

  double evaluate_variables(const VectorX& x) const { return reduce(case_values(x)); }

  VectorX case_values(const VectorX& x) const {
    VectorX values(size());
    for (std::size_t k = 0; k < case_objectives_.size(); ++k) {
      const VectorX case_values = space_.values(k, x);
      values[static_cast<Eigen::Index>(k)] = case_objectives_[k].function->evaluate(
          case_objectives_[k].is_of_parameters()
              ? dynamics::parameter_values(instantiate_checked(space_.cases[k], case_values).mechanism,
                                           offsets_[k].loose)
              : case_values,
          nullptr);
    }
    return values;
  }

  /// Appends the functions of one maximum to those of another of the same weight.
  static void append(const MaxTerm& term, MaxTerm& all) {
    VectorX values(all.values.size() + term.values.size());
    values << all.values, term.values;
    MatrixX jacobian(values.size(), all.jacobian.cols());
    jacobian << all.jacobian, term.jacobian;
    all.values = std::move(values);
    all.jacobian = std::move(jacobian);
  }
  Eigen::Index size() const { return static_cast<Eigen::Index>(case_objectives_.size()); }
  double reduce(const VectorX& values) const {
    if (!values.allFinite()) return NAN;
    if (reduction_ == CaseReduction::mean) return values.mean();
    return reduction_ == CaseReduction::min ? numerics::min_coefficient(values) : numerics::max_coefficient(values);
  }

  CaseSpace space_;
  CaseReduction reduction_;
  std::size_t term_count_;
  bool is_range_;  ///< of the first term: a sum of two maxima
  std::vector<CaseOffsets> offsets_;
  std::vector<Objective> case_objectives_;
};

/// Rewrites a figure of one case as one of the parameters of all cases.
AffineFigure expand_to_all_cases(AffineFigure figure, const CaseOffsets& offset, Eigen::Index parameter_count) {
  if (figure.coefficients.size() > 0) {
    const VectorX coefficients = figure.coefficients;
    figure.coefficients.setZero(parameter_count);
    figure.coefficients(offset.parameters) = coefficients;
  }
  for (AffineSeries& series : figure.series) {
    const MatrixX rows = series.rows;
    series.rows.setZero(rows.rows(), parameter_count + 1);
    series.rows(Eigen::all, offset.parameters) = rows.leftCols(rows.cols() - 1);
    series.rows.col(parameter_count) = rows.rightCols(1);
  }
  return figure;
}

using Figures = std::optional<std::vector<AffineFigure>>;

/// Rewrites a nonnegative linear figure as the peak of a series with one sample.
void make_series(AffineFigure& figure) {
  if (figure.coefficients.size() == 0) return;
  AffineSeries one;
  one.rows.setZero(1, figure.coefficients.size() + 1);
  one.rows.leftCols(figure.coefficients.size()) = figure.coefficients.transpose();
  one.components = 1;
  one.time_weights = VectorX::Ones(1);
  figure = {figure.weight, {}, Statistic::peak, {std::move(one)}};
}

/// The worst of a figure over the cases is a single figure with the series of all cases.
Figures combine_case_figures(std::vector<std::vector<AffineFigure>> case_figures, CaseAggregation across) {
  std::vector<AffineFigure> all;
  const double case_weight = across == CaseAggregation::mean ? 1.0 / static_cast<double>(case_figures.size()) : 1;
  for (std::vector<AffineFigure>& figures : case_figures)
    for (AffineFigure& figure : figures) {
      if (across == CaseAggregation::worst) make_series(figure);
      if (across == CaseAggregation::worst && !all.empty()) {
        std::move(figure.series.begin(), figure.series.end(), std::back_inserter(all.front().series));
        continue;
      }
      figure.weight *= case_weight;
      all.push_back(std::move(figure));
    }
  return all;
}

}  // namespace

namespace {

Objective build_reduced_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms,
                                  CaseReduction reduction, const dynamics::FreeSprings& loose, MotionCache& cache) {
  auto function = std::make_shared<const CaseFunction>(space, terms, reduction, loose, cache);
  const std::vector<Objective>& case_objectives = function->case_objectives();
  const auto all = [&](auto&& holds) { return std::all_of(case_objectives.begin(), case_objectives.end(), holds); };
  Objective objective;
  objective.name = case_objectives.front().name +
                   (reduction == CaseReduction::mean ? " on average over the cases" : " in the worst case");
  objective.unit = case_objectives.front().unit;
  objective.is_convex = reduction != CaseReduction::min && all([](const Objective& one) { return one.is_convex; });
  objective.is_concave = reduction != CaseReduction::max && all([](const Objective& one) { return one.is_concave; });
  objective.is_secondary = all([](const Objective& one) { return one.is_secondary; });
  objective.lower_bound = case_objectives.front().lower_bound;
  objective.function = std::move(function);
  return objective;
}

}  // namespace

Objective build_case_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, CaseAggregation across,
                               const dynamics::FreeSprings& loose, MotionCache& cache) {
  return build_reduced_objective(space, terms, case_reduction(across), loose, cache);
}

std::vector<DesignLimit> build_case_limits(const CaseSpace& space, const std::vector<study::FigureLimit>& limits,
                                           const dynamics::FreeSprings& loose, MotionCache& cache) {
  std::vector<DesignLimit> built;
  for (const study::FigureLimit& limit : limits)
    built.push_back(
        {limit.text,
         build_reduced_objective(space, limit.terms,
                                 limit.is_lower ? CaseReduction::min : case_reduction(limit.aggregation), loose, cache),
         limit.is_lower, limit.bound});
  return built;
}

namespace {

/// A limit on the mean is a single limit with the figures of all cases; a limit on the worst value applies to every
/// case.
void add_limit(std::vector<ConvexLimit> case_limits, CaseAggregation across, std::vector<ConvexLimit>& all) {
  if (across == CaseAggregation::worst) {
    std::move(case_limits.begin(), case_limits.end(), std::back_inserter(all));
    return;
  }
  ConvexLimit mean{{}, case_limits.front().bound};
  for (ConvexLimit& limit : case_limits)
    for (AffineFigure& figure : limit.figures) {
      figure.weight /= static_cast<double>(case_limits.size());
      mean.figures.push_back(std::move(figure));
    }
  all.push_back(std::move(mean));
}

}  // namespace

CaseFigures::CaseFigures(const CaseSpace& space, const dynamics::FreeSprings& loose)
    : space_(space), offsets_(case_offsets(space, loose)), parameter_count_(count_parameters(offsets_)) {}

namespace {

/// Whether the terms of all cases combine to a figure of series; the worst of several sums, as ranges are and orders may
/// be, does not.
bool are_combinable(const Mechanism& mechanism, const std::vector<ObjectiveTerm>& terms, CaseAggregation across) {
  const auto is_sum_of_figures = [&](const ObjectiveTerm& term) {
    if (term.size != ObjectiveTerm::Size::none) return false;
    // of a vector in the plane, the radii of two circles
    return term.figure == Statistic::range ||
           (term.run == ObjectiveTerm::RunMeasure::order && term.part == results::OrderPart::whole &&
            !is_scalar_quantity(mechanism, term.quantity));
  };
  const bool is_sum = terms.size() > 1 || (!terms.empty() && is_sum_of_figures(terms.front()));
  return !(across == CaseAggregation::worst && is_sum);
}

}  // namespace

bool CaseFigures::are_convex(const std::vector<ObjectiveTerm>& terms, CaseAggregation across) const {
  return are_combinable(space_.cases.front().start.mechanism, terms, across) &&
         std::all_of(space_.cases.begin(), space_.cases.end(),
                     [&](const DesignSpace& one) { return are_convex_in_parameters(one, terms); });
}

bool CaseFigures::are_affine(const std::vector<ObjectiveTerm>& terms, CaseAggregation across) const {
  return are_combinable(space_.cases.front().start.mechanism, terms, across) &&
         std::all_of(space_.cases.begin(), space_.cases.end(),
                     [&](const DesignSpace& one) { return are_statistics_of_affine_quantities(one, terms); });
}

Figures CaseFigures::terms(const std::vector<ObjectiveTerm>& terms, CaseAggregation across, FigureSampling sampling,
                           const VectorX& x, MotionCache& cache) const {
  std::vector<std::vector<AffineFigure>> case_figures;
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    Figures figures =
        compute_convex_terms(space_.cases[k], terms, offsets_[k].loose, sampling, space_.values(k, x), cache);
    if (!figures) return std::nullopt;
    for (AffineFigure& figure : *figures)
      figure = expand_to_all_cases(std::move(figure), offsets_[k], parameter_count_);
    case_figures.push_back(std::move(*figures));
  }
  return combine_case_figures(std::move(case_figures), across);
}

std::vector<study::FigureLimit> CaseFigures::select_convex_limits(const std::vector<study::FigureLimit>& limits) const {
  std::vector<study::FigureLimit> convex = limits;
  for (const DesignSpace& one : space_.cases) convex = design::select_convex_limits(one, convex);
  return convex;
}

std::optional<std::vector<ConvexLimit>> CaseFigures::limits(const std::vector<study::FigureLimit>& limits,
                                                            const VectorX& x, MotionCache& cache) const {
  std::vector<ConvexLimit> all;
  for (const study::FigureLimit& limit : limits) {
    std::vector<ConvexLimit> case_limits;
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
      auto case_limit = compute_convex_limits(space_.cases[k], {limit}, offsets_[k].loose, space_.values(k, x), cache);
      if (!case_limit) return std::nullopt;
      for (AffineFigure& figure : case_limit->front().figures)
        figure = expand_to_all_cases(std::move(figure), offsets_[k], parameter_count_);
      case_limits.push_back(std::move(case_limit->front()));
    }
    add_limit(std::move(case_limits), limit.aggregation, all);
  }
  return all;
}

VectorX CaseSpace::values(std::size_t case_index, const VectorX& x) const { return x(variable_index[case_index]); }

VectorX CaseSpace::start_values() const {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) x[static_cast<Eigen::Index>(i)] = numbers[i].start;
  return x;
}

CaseSpace CaseSpace::fix_others(const VectorX& x, const std::vector<int>& free_numbers) const {
  CaseSpace restricted;
  for (const int i : free_numbers) {
    restricted.numbers.push_back(numbers[static_cast<std::size_t>(i)]);
    restricted.numbers.back().start = x[i];
  }
  for (std::size_t k = 0; k < cases.size(); ++k) {
    std::vector<int> case_variables, index;
    for (std::size_t i = 0; i < variable_index[k].size(); ++i) {
      const auto at = std::find(free_numbers.begin(), free_numbers.end(), variable_index[k][i]);
      if (at == free_numbers.end()) continue;
      case_variables.push_back(static_cast<int>(i));
      index.push_back(static_cast<int>(at - free_numbers.begin()));
    }
    restricted.cases.push_back(cases[k].fix_others(values(k, x), case_variables));
    restricted.variable_index.push_back(std::move(index));
  }
  return restricted;
}

CaseSpace make_case_space(const DesignSpace& space) {
  const study::LoadCases& loads = space.start.design.cases;
  const auto& free = space.start.free_numbers;
  const auto adapted = [&](std::size_t i) {
    return std::find(loads.adapted.begin(), loads.adapted.end(), static_cast<int>(i)) != loads.adapted.end();
  };
  CaseSpace case_space;
  std::vector<int> shared(free.size(), -1);
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (adapted(i)) continue;
    shared[i] = static_cast<int>(case_space.numbers.size());
    case_space.numbers.push_back(free[i]);
  }
  for (Eigen::Index k = 0; k < loads.size(); ++k) {
    const VectorX load = loads.values.row(k);
    case_space.cases.push_back(at_load(space, load));
    case_space.variable_index.push_back(shared);
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (!adapted(i)) continue;
      case_space.variable_index.back()[i] = static_cast<int>(case_space.numbers.size());
      case_space.numbers.push_back(free[i]);
      case_space.numbers.back().key_path += fmt::format(" ({})", load_text(loads.numbers, load));
    }
  }
  return case_space;
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

std::string load_text(const std::vector<study::LoadParameter>& numbers, const VectorX& loads) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    text += fmt::format("{}{} = {:.6g}", i == 0 ? "" : ", ", numbers[i].name,
                        loads[static_cast<Eigen::Index>(i)] / numbers[i].unit);
  return text;
}

}  // namespace balance::design
