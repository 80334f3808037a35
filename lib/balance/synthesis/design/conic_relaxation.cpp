#include "balance/synthesis/design/conic_relaxation.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Weights of rows and limits against a figure of size one: exact unless a multiplier is beyond them, a bound in any case, and the smaller
/// they are the more digits are kept.
constexpr double penalty_weights[] = {30, 1e3, 3e4};
/// Round-off of a program's rows.
constexpr double row_tolerance = 1e-12;

std::vector<bool> find_active_parameters(const SolverContext& context, const MatrixX& rows,
                                         const std::vector<AffineFigure>& figures,
                                         const std::vector<ConvexLimit>& limits) {
  std::vector<bool> matters(list_terms(context.classification.base_mechanism, context.options.loose_springs).size(),
                            false);
  const double largest = max_abs(rows.colwise().norm());
  for (std::size_t k = 0; k < matters.size() && rows.rows() > 0; ++k)
    matters[k] = rows.col(static_cast<Eigen::Index>(k)).norm() > 1e-12 * largest;
  mark_active_parameters(figures, matters);
  for (const ConvexLimit& limit : limits) mark_active_parameters(limit.figures, matters);
  return matters;
}

/// A program with some of its variables at values.
struct PresolvedProgram {
  ConeProgram program;
  double constant = 0;  ///< what they cost
  bool possible = true;
  std::vector<Eigen::Index> kept;
};

class ConePresolve {
 public:
  ConePresolve(const ConeProgram& whole, const std::vector<std::pair<Eigen::Index, double>>& held) : whole_(whole) {
    std::vector<bool> stays(static_cast<std::size_t>(whole.cost.size()), false);
    right_ = whole.rhs;
    for (const auto& [k, value] : held) {
      stays[static_cast<std::size_t>(k)] = true;
      right_ -= whole.matrix.col(k) * value;
      out_.constant += whole.cost[k] * value;
    }
    for (Eigen::Index k = 0; k < whole.cost.size(); ++k)
      if (!stays[static_cast<std::size_t>(k)]) out_.kept.push_back(k);
  }

  PresolvedProgram run() {
    columns_ = whole_.matrix(Eigen::all, out_.kept);
    ConeProgramBuilder rows(columns_.cols());
    for (Eigen::Index i = 0; i < whole_.linear_rows; ++i) {
      if (!columns_.row(i).isZero(0))
        rows.add_inequalities(VectorX(columns_.row(i).transpose()), right_[i]);
      else if (right_[i] < -row_tolerance * scale(i, 1))
        out_.possible = false;
    }
    Eigen::Index row = whole_.linear_rows;
    for (const Eigen::Index size : whole_.cone_sizes) {
      add_cone(row, size, rows);
      row += size;
    }
    out_.program = rows.build(whole_.cost(out_.kept));
    return std::move(out_);
  }

 private:
  double scale(Eigen::Index row, Eigen::Index count) const {
    return 1 + max_abs(whole_.rhs.segment(row, count)) + max_abs(whole_.matrix.middleRows(row, count));
  }
  void add_cone(Eigen::Index row, Eigen::Index size, ConeProgramBuilder& rows) {
    const VectorX constant = right_.segment(row, size);
    if (!columns_.middleRows(row, size).isZero(0))
      rows.add_cone(-columns_.middleRows(row, size), constant);
    else if (constant[0] < constant.tail(size - 1).norm() - 1e-9 * scale(row, size))
      out_.possible = false;
  }

  const ConeProgram& whole_;
  VectorX right_;
  MatrixX columns_;
  PresolvedProgram out_;
};

}  // namespace

ConicRelaxation::ConicRelaxation(const SolverContext& context, const MatrixX& rows,
                                 const std::vector<AffineFigure>& figures, const std::vector<ConvexLimit>& limits)
    : context_(context),
      model_(context, context.scaling.start(), find_active_parameters(context, rows, figures, limits)),
      has_figure_(!figures.empty()) {
  std::optional<AffineTerms> terms = model_.evaluate(context.scaling.start());
  known_ = terms.has_value();
  if (!known_) return;
  data_.terms = std::move(*terms);
  data_.rows = rows * data_.terms.matrix;
  data_.right = -rows * data_.terms.constant;
  VectorX middle = VectorX::Zero(data_.terms.matrix.cols() + 1), high = VectorX::Ones(middle.size());
  middle[middle.size() - 1] = 1;
  double low_size = 0, high_size = 0;
  for (const AffineFigure& figure : figures) {
    data_.figures.push_back({express_in_unknowns(figure, data_.terms)});
    low_size += figure.weight * data_.figures.back().figure(middle);
    high_size += figure.weight * data_.figures.back().figure(high);
  }
  size_ = std::max(std::abs(low_size), 1e-3 * std::abs(high_size));
  if (!(size_ > 0)) size_ = 1;
  for (InnerFigure& one : data_.figures) one.scale = size_;
  data_.limit_bounds.resize(static_cast<Eigen::Index>(limits.size()));
  for (std::size_t l = 0; l < limits.size(); ++l) {
    const double bound = limits[l].bound, size = bound != 0 ? std::abs(bound) : size_;
    data_.limit_bounds[static_cast<Eigen::Index>(l)] = bound / size;
    for (const AffineFigure& figure : limits[l].figures)
      data_.figures.push_back({express_in_unknowns(figure, data_.terms), size, static_cast<int>(l)});
  }
}

/// How far the unknowns are from what is demanded, of rows and limits.
double ConicRelaxation::max_violation(const VectorX& unknowns, bool rows) const {
  VectorX with_one(unknowns.size() + 1), beyond = -data_.limit_bounds;
  with_one << unknowns, 1;
  for (const auto& [figure, size, limit] : data_.figures)
    if (limit >= 0) beyond[limit] += figure.weight / size * figure(with_one);
  double worst = std::max(0.0, max_coefficient(beyond));
  if (rows) worst = std::max(worst, (data_.rows * unknowns - data_.right).norm());
  return worst;
}

bool ConicRelaxation::is_complete() const {
  return known_ && std::all_of(model_.outer().begin(), model_.outer().end(),
                               [&](int i) { return context_.scaling.half_width()[i] == 0; });
}

/// Bounds of the linear unknowns are the first rows of their limits, from above and then from below.
InnerData ConicRelaxation::restrict_data(const VariableDomain& part, FixedUnknowns& held) const {
  InnerData data = data_;
  ConeProgram& limits = data.terms.constraints;
  const std::vector<int>& linear = model_.linear();
  const auto n = static_cast<Eigen::Index>(linear.size());
  const VariableScaling& box = context_.scaling;
  const auto unit = [&](int i, double number) {
    return box.half_width()[i] > 0 ? std::clamp((number - box.centre()[i]) / box.half_width()[i], -1.0, 1.0) : 0.0;
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const int i = linear[static_cast<std::size_t>(k)];
    limits.rhs[k] = unit(i, part.upper[i]);
    limits.rhs[n + k] = -unit(i, part.lower[i]);
    if (part.lower[i] == part.upper[i] || box.half_width()[i] == 0) held.emplace_back(k, limits.rhs[k]);
  }
  ConeProgramBuilder rows(limits.matrix.cols());
  if (!part.linear_limits.empty()) {
    for (const auto& [coefficients, most] : part.linear_limits) {
      VectorX row = VectorX::Zero(limits.matrix.cols());
      double rest = most;
      for (Eigen::Index k = 0; k < n; ++k) {
        const int i = linear[static_cast<std::size_t>(k)];
        row[k] = coefficients[i] * box.half_width()[i];
        rest -= coefficients[i] * box.centre()[i];
      }
      rows.add_inequalities(row, rest);
    }
    const ConeProgram sums = rows.build(VectorX::Zero(limits.matrix.cols()));
    limits = add_inequalities(limits, sums.matrix, sums.rhs);
  }
  for (const Eigen::Index k : model_.list_massless_unknowns(data.terms, part.upper)) held.emplace_back(k, 0.0);
  return data;
}

ConicRelaxation::ProgramResult ConicRelaxation::solve(const VariableDomain& part, bool figures, bool rows,
                                                      double weight) const {
  FixedUnknowns held;
  const InnerData data = restrict_data(part, held);
  InnerProgramBuilder builder(data, figures, rows);
  builder.add_unknown_constraints();
  std::vector<FigureRows> pieces;
  if (figures)
    for (std::size_t k = 0; k < data.figures.size(); ++k) builder.add_figure(k, pieces);
  if (figures) builder.add_limits(weight);
  if (rows) builder.add_residual(weight);
  PresolvedProgram reduced = ConePresolve(builder.build(pieces), held).run();
  ProgramResult answer;
  if (!reduced.possible) return answer;
  VectorX all = VectorX::Zero(builder.unknowns());
  for (const auto& [k, value] : held) all[k] = value;
  if (!reduced.kept.empty()) {
    const ConeSolution found = solve_cone_program(reduced.program);
    if (found.status != ConeStatus::optimal) {
      answer.bound = std::numeric_limits<double>::quiet_NaN();
      return answer;
    }
    answer.bound = found.dual_value;
    for (std::size_t k = 0; k < reduced.kept.size(); ++k)
      if (reduced.kept[k] < all.size()) all[reduced.kept[k]] = found.x[static_cast<Eigen::Index>(k)];
  }
  answer.status = ConeStatus::optimal;
  answer.bound += reduced.constant;
  for (const auto& [figure, size, limit] : data.figures)  // a sum's constant is no cost of the program's
    if (figures && limit < 0 && figure.series.empty())
      answer.bound += figure.weight / size * figure.coefficients.tail(1)[0];
  answer.unknowns = all;
  return answer;
}

RelaxationBound ConicRelaxation::make_bound(const ProgramResult& answer, const VariableDomain& part) const {
  RelaxationBound design;
  // a program that is out of numerical reach says nothing
  design.is_feasible = answer.status == ConeStatus::optimal || std::isnan(answer.bound);
  if (answer.status != ConeStatus::optimal) return design;
  design.x = context_.scaling.to_variables(model_.recover_variables(context_.scaling.start(), answer.unknowns));
  design.x = design.x.cwiseMax(part.lower).cwiseMin(part.upper);
  return design;
}

RelaxationBound ConicRelaxation::minimise_residual(const VariableDomain& part) const {
  if (data_.rows.rows() == 0) {
    RelaxationBound design;
    design.is_feasible = true;
    design.residual = 0;
    return design;
  }
  const ProgramResult answer = solve(part, false, true, 1);
  RelaxationBound design = make_bound(answer, part);
  if (design.x.size() > 0) design.residual = std::max(0.0, answer.bound);
  return design;
}

RelaxationBound ConicRelaxation::minimise_constrained_figure(const VariableDomain& part) const {
  if (data_.rows.rows() == 0) return minimise_figure(part);
  RelaxationBound design = minimise_residual(part);
  if (!design.is_feasible || !has_figure_) return design;
  if (design.residual > relaxed_residual_tolerance) return design;
  RelaxationBound best = minimise_penalised(part, true);
  best.residual = design.residual;
  return best;
}

RelaxationBound ConicRelaxation::minimise_figure(const VariableDomain& part) const {
  RelaxationBound best = minimise_penalised(part, false);
  best.residual = 0;
  return best;
}

/// With heavier and heavier weights until everything demanded is met; every one of them gives a bound.
RelaxationBound ConicRelaxation::minimise_penalised(const VariableDomain& part, bool rows) const {
  RelaxationBound best;
  double bound = -std::numeric_limits<double>::infinity();
  for (const double weight : penalty_weights) {
    const ProgramResult answer = solve(part, true, rows, weight);
    const RelaxationBound found = make_bound(answer, part);
    if (!rows && data_.limit_bounds.size() == 0) best.is_feasible = found.is_feasible;
    if (found.x.size() == 0) continue;
    best = found;
    bound = std::max(bound, answer.bound);
    if (max_violation(answer.unknowns, rows) < relaxed_residual_tolerance) break;
  }
  if (rows || data_.limit_bounds.size() > 0) best.is_feasible = true;
  if (best.x.size() > 0 && has_figure_) best.figure = size_ * bound;
  return best;
}

}  // namespace balance::design
