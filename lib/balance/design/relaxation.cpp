#include "balance/design/relaxation.hpp"

#include "balance/base/extrema.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Weights of rows and limits against a figure of size one: exact unless a multiplier is beyond them, a bound in any case, and the smaller
/// they are the more digits are kept.
constexpr double weights[] = {30, 1e3, 3e4};
/// Round-off of a program's rows.
constexpr double of_a_row = 1e-12;

std::vector<bool> find_what_matters(const Context& context, const MatrixX& rows,
                                    const std::vector<LinearFigure>& figures,
                                    const std::vector<BoundedFigures>& limits) {
  std::vector<bool> matters(list_terms(context.survey.at_base, context.options.loose_springs).size(), false);
  const double largest = max_abs(rows.colwise().norm());
  for (std::size_t k = 0; k < matters.size() && rows.rows() > 0; ++k)
    matters[k] = rows.col(static_cast<Eigen::Index>(k)).norm() > 1e-12 * largest;
  mark_what_matters(figures, matters);
  for (const BoundedFigures& limit : limits) mark_what_matters(limit.figures, matters);
  return matters;
}

/// A program with some of its variables at values.
struct Reduced {
  ConeProgram program;
  double constant = 0;  ///< what they cost
  bool possible = true;
  std::vector<Eigen::Index> kept;
};

class Reduction {
 public:
  Reduction(const ConeProgram& whole, const std::vector<std::pair<Eigen::Index, double>>& held) : whole_(whole) {
    std::vector<bool> stays(static_cast<std::size_t>(whole.cost.size()), false);
    right_ = whole.right;
    for (const auto& [k, value] : held) {
      stays[static_cast<std::size_t>(k)] = true;
      right_ -= whole.matrix.col(k) * value;
      out_.constant += whole.cost[k] * value;
    }
    for (Eigen::Index k = 0; k < whole.cost.size(); ++k)
      if (!stays[static_cast<std::size_t>(k)]) out_.kept.push_back(k);
  }

  Reduced run() {
    columns_ = whole_.matrix(Eigen::all, out_.kept);
    ConeRows rows(columns_.cols());
    for (Eigen::Index i = 0; i < whole_.linear; ++i) {
      if (!columns_.row(i).isZero(0))
        rows.at_most(VectorX(columns_.row(i).transpose()), right_[i]);
      else if (right_[i] < -of_a_row * scale(i, 1))
        out_.possible = false;
    }
    Eigen::Index row = whole_.linear;
    for (const Eigen::Index size : whole_.cones) {
      add_cone(row, size, rows);
      row += size;
    }
    out_.program = rows.finish(whole_.cost(out_.kept));
    return std::move(out_);
  }

 private:
  double scale(Eigen::Index row, Eigen::Index count) const {
    return 1 + max_abs(whole_.right.segment(row, count)) + max_abs(whole_.matrix.middleRows(row, count));
  }
  void add_cone(Eigen::Index row, Eigen::Index size, ConeRows& rows) {
    const VectorX constant = right_.segment(row, size);
    if (!columns_.middleRows(row, size).isZero(0))
      rows.in_cone(-columns_.middleRows(row, size), constant);
    else if (constant[0] < constant.tail(size - 1).norm() - 1e-9 * scale(row, size))
      out_.possible = false;
  }

  const ConeProgram& whole_;
  VectorX right_;
  MatrixX columns_;
  Reduced out_;
};

}  // namespace

Relaxation::Relaxation(const Context& context, const MatrixX& rows, const std::vector<LinearFigure>& figures,
                       const std::vector<BoundedFigures>& limits)
    : context_(context),
      model_(context, context.box.start(), find_what_matters(context, rows, figures, limits)),
      has_figure_(!figures.empty()) {
  std::optional<InertialTerms> terms = model_.at(context.box.start());
  known_ = terms.has_value();
  if (!known_) return;
  data_.terms = std::move(*terms);
  data_.rows = rows * data_.terms.matrix;
  data_.right = -rows * data_.terms.constant;
  VectorX middle = VectorX::Zero(data_.terms.matrix.cols() + 1), high = VectorX::Ones(middle.size());
  middle[middle.size() - 1] = 1;
  double low_size = 0, high_size = 0;
  for (const LinearFigure& figure : figures) {
    data_.figures.push_back({of_unknowns(figure, data_.terms)});
    low_size += figure.weight * data_.figures.back().figure(middle);
    high_size += figure.weight * data_.figures.back().figure(high);
  }
  size_ = std::max(std::abs(low_size), 1e-3 * std::abs(high_size));
  if (!(size_ > 0)) size_ = 1;
  for (InnerFigure& one : data_.figures) one.size = size_;
  data_.bounds.resize(static_cast<Eigen::Index>(limits.size()));
  for (std::size_t l = 0; l < limits.size(); ++l) {
    const double bound = limits[l].bound, size = bound != 0 ? std::abs(bound) : size_;
    data_.bounds[static_cast<Eigen::Index>(l)] = bound / size;
    for (const LinearFigure& figure : limits[l].figures)
      data_.figures.push_back({of_unknowns(figure, data_.terms), size, static_cast<int>(l)});
  }
}

/// How far the unknowns are from what is demanded, of rows and limits.
double Relaxation::missed(const VectorX& unknowns, bool rows) const {
  VectorX with_one(unknowns.size() + 1), beyond = -data_.bounds;
  with_one << unknowns, 1;
  for (const auto& [figure, size, limit] : data_.figures)
    if (limit >= 0) beyond[limit] += figure.weight / size * figure(with_one);
  double worst = std::max(0.0, max_coefficient(beyond));
  if (rows) worst = std::max(worst, (data_.rows * unknowns - data_.right).norm());
  return worst;
}

bool Relaxation::complete() const {
  return known_ &&
         std::all_of(model_.outer().begin(), model_.outer().end(), [&](int i) { return context_.box.half()[i] == 0; });
}

/// Bounds of the linear unknowns are the first rows of their limits, from above and then from below.
InnerData Relaxation::narrowed(const Narrowed& part, Held& held) const {
  InnerData data = data_;
  ConeProgram& limits = data.terms.limits;
  const std::vector<int>& linear = model_.linear();
  const auto n = static_cast<Eigen::Index>(linear.size());
  const Box& box = context_.box;
  const auto unit = [&](int i, double number) {
    return box.half()[i] > 0 ? std::clamp((number - box.centre()[i]) / box.half()[i], -1.0, 1.0) : 0.0;
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const int i = linear[static_cast<std::size_t>(k)];
    limits.right[k] = unit(i, part.upper[i]);
    limits.right[n + k] = -unit(i, part.lower[i]);
    if (part.lower[i] == part.upper[i] || box.half()[i] == 0) held.emplace_back(k, limits.right[k]);
  }
  ConeRows rows(limits.matrix.cols());
  if (!part.sums.empty()) {
    for (const auto& [coefficients, most] : part.sums) {
      VectorX row = VectorX::Zero(limits.matrix.cols());
      double rest = most;
      for (Eigen::Index k = 0; k < n; ++k) {
        const int i = linear[static_cast<std::size_t>(k)];
        row[k] = coefficients[i] * box.half()[i];
        rest -= coefficients[i] * box.centre()[i];
      }
      rows.at_most(row, rest);
    }
    const ConeProgram sums = rows.finish(VectorX::Zero(limits.matrix.cols()));
    limits = with_inequalities(limits, sums.matrix, sums.right);
  }
  for (const Eigen::Index k : model_.massless(data.terms, part.upper)) held.emplace_back(k, 0.0);
  return data;
}

Relaxation::Answer Relaxation::solve(const Narrowed& part, bool figures, bool rows, double weight) const {
  Held held;
  const InnerData data = narrowed(part, held);
  InnerProgram builder(data, figures, rows);
  builder.add_limits();
  std::vector<FigurePiece> pieces;
  if (figures)
    for (std::size_t k = 0; k < data.figures.size(); ++k) builder.add_figure(k, pieces);
  if (figures) builder.add_bounds(weight);
  if (rows) builder.add_residual(weight);
  Reduced reduced = Reduction(builder.finish(pieces), held).run();
  Answer answer;
  if (!reduced.possible) return answer;
  VectorX all = VectorX::Zero(builder.unknowns());
  for (const auto& [k, value] : held) all[k] = value;
  if (!reduced.kept.empty()) {
    const ConeSolution found = minimise(reduced.program);
    if (found.status != ConeStatus::solved) {
      answer.bound = std::numeric_limits<double>::quiet_NaN();
      return answer;
    }
    answer.bound = found.bound;
    for (std::size_t k = 0; k < reduced.kept.size(); ++k)
      if (reduced.kept[k] < all.size()) all[reduced.kept[k]] = found.x[static_cast<Eigen::Index>(k)];
  }
  answer.status = ConeStatus::solved;
  answer.bound += reduced.constant;
  for (const auto& [figure, size, limit] : data.figures)  // a sum's constant is no cost of the program's
    if (figures && limit < 0 && figure.series.empty())
      answer.bound += figure.weight / size * figure.coefficients.tail(1)[0];
  answer.unknowns = all;
  return answer;
}

RelaxedDesign Relaxation::read(const Answer& answer, const Narrowed& part) const {
  RelaxedDesign design;
  // a program that is out of numerical reach says nothing
  design.possible = answer.status == ConeStatus::solved || std::isnan(answer.bound);
  if (answer.status != ConeStatus::solved) return design;
  design.x = context_.box.numbers(model_.recovered(context_.box.start(), answer.unknowns));
  design.x = design.x.cwiseMax(part.lower).cwiseMin(part.upper);
  return design;
}

RelaxedDesign Relaxation::least_residual(const Narrowed& part) const {
  if (data_.rows.rows() == 0) {
    RelaxedDesign design;
    design.possible = true;
    design.residual = 0;
    return design;
  }
  const Answer answer = solve(part, false, true, 1);
  RelaxedDesign design = read(answer, part);
  if (design.x.size() > 0) design.residual = std::max(0.0, answer.bound);
  return design;
}

RelaxedDesign Relaxation::least_figure(const Narrowed& part) const {
  if (data_.rows.rows() == 0) return least_figure_regardless(part);
  RelaxedDesign design = least_residual(part);
  if (!design.possible || !has_figure_) return design;
  if (design.residual > can_be_met) return design;
  RelaxedDesign best = weighed(part, true);
  best.residual = design.residual;
  return best;
}

RelaxedDesign Relaxation::least_figure_regardless(const Narrowed& part) const {
  RelaxedDesign best = weighed(part, false);
  best.residual = 0;
  return best;
}

/// With heavier and heavier weights until everything demanded is met; every one of them gives a bound.
RelaxedDesign Relaxation::weighed(const Narrowed& part, bool rows) const {
  RelaxedDesign best;
  double bound = -std::numeric_limits<double>::infinity();
  for (const double weight : weights) {
    const Answer answer = solve(part, true, rows, weight);
    const RelaxedDesign found = read(answer, part);
    if (!rows && data_.bounds.size() == 0) best.possible = found.possible;
    if (found.x.size() == 0) continue;
    best = found;
    bound = std::max(bound, answer.bound);
    if (missed(answer.unknowns, rows) < can_be_met) break;
  }
  if (rows || data_.bounds.size() > 0) best.possible = true;
  if (best.x.size() > 0 && has_figure_) best.figure = size_ * bound;
  return best;
}

}  // namespace balance::designing
