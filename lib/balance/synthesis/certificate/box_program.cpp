#include "balance/synthesis/certificate/box_program.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/inequality_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::certificate {
namespace {

/// Relative: a mass above its limit by less is round-off of the solver.
constexpr double mass_limit_tolerance = 1e-9;
constexpr double min_active_multiplier = 1e-12;

std::vector<LengthPolynomial> list_polynomials(const VirtualHeight& height) {
  std::vector<LengthPolynomial> all{height.scale};
  all.insert(all.end(), height.coefficients.begin(), height.coefficients.end());
  return all;
}

std::vector<LengthPolynomial> list_objective(const VirtualLinkage& dual,
                                             const std::vector<LengthCondition>& conditions) {
  std::vector<LengthPolynomial> all = list_polynomials(dual.fixed_masses);
  all.insert(all.begin(), dual.fixed_size);
  for (const LengthCondition& condition : conditions) all.push_back(condition.polynomial);
  return all;
}

/// Bernstein coefficients of the columns from `first` on, multiplied by 1 and by 2t − 1 of each affine length: all with
/// the same degrees. Blocks of columns in that order.
struct ExpandedColumns {
  BernsteinCoefficients plain;   ///< all columns, elevated
  std::vector<MatrixX> centred;  ///< per affine length: all columns times 2t − 1
};

ExpandedColumns expand(const BernsteinCoefficients& coefficients, const std::vector<int>& affine) {
  ExpandedColumns result{coefficients, {}};
  for (const int length : affine) result.plain.axis(length);
  const BernsteinCoefficients base = result.plain;
  for (const int length : affine) result.plain.elevate(result.plain.axis(length));
  for (const int factor : affine) {
    BernsteinCoefficients product = base;
    for (const int length : affine) {
      const std::size_t axis = product.axis(length);
      if (length == factor)
        product.multiply_by_centred(axis);
      else
        product.elevate(axis);
    }
    result.centred.push_back(std::move(product.values));
  }
  return result;
}

}  // namespace

/// The rows of a box's program, each divided by its scale so that its right-hand side is 1 (0 for signs of σ).
struct BoxProgram::Assembly {
  enum class Kind { height, sign, objective };
  struct Block {
    Kind kind = Kind::height;
    int counterweight = -1, corner = -1;
    Eigen::Index begin = 0, count = 0;
    BernsteinCoefficients shape;  ///< without values: the indices of the rows
    VectorX scales;               ///< per row
    VectorX magnitudes;           ///< per unknown: bound on absolute terms, before the division by the scale
    double constant_magnitude = 0;
  };

  Eigen::Index unknowns, limits, parts, size;  ///< w, σ, 1 + affine lengths; all with κ and γ
  std::vector<int> conditions;                 ///< that take part
  std::vector<bool> is_equality;
  std::vector<int> limit_index;
  MatrixX rows;
  VectorX right;
  Eigen::Index count = 0;
  std::vector<Block> blocks;

  Eigen::Index w_column(Eigen::Index part, Eigen::Index w) const { return part * unknowns + w; }
  Eigen::Index limit_column(Eigen::Index part, Eigen::Index limit) const {
    return parts * unknowns + part * limits + limit;
  }
  Eigen::Index condition_column(std::size_t index) const {
    return parts * (unknowns + limits) + static_cast<Eigen::Index>(index);
  }
  Eigen::Index bound_column() const { return size - 1; }

  void reserve(Eigen::Index more) {
    if (count + more <= rows.rows()) return;
    const Eigen::Index capacity = std::max<Eigen::Index>(count + more, 2 * rows.rows());
    rows.conservativeResize(capacity, size);
    right.conservativeResize(capacity);
  }

  Block& add_block(Block block) {
    reserve(block.count);
    block.begin = count;
    rows.middleRows(count, block.count).setZero();
    count += block.count;
    blocks.push_back(std::move(block));
    return blocks.back();
  }

  /// Σ_w column_w · w over the parts, divided by the scales; the columns of w begin at `first`.
  void set_w(Block& block, const ExpandedColumns& columns, Eigen::Index first, double sign) {
    for (Eigen::Index part = 0; part < parts; ++part) {
      const MatrixX& values = part == 0 ? columns.plain.values : columns.centred[static_cast<std::size_t>(part - 1)];
      for (Eigen::Index w = 0; w < unknowns; ++w) {
        rows.block(block.begin, w_column(part, w), block.count, 1) =
            sign * values.col(first + w).cwiseQuotient(block.scales);
        block.magnitudes[w_column(part, w)] = columns.plain.magnitudes[first + w];
      }
    }
  }

  /// factor · scale · σ over the parts, divided by the scales; the scale is column `scale`.
  void set_limit(Block& block, const ExpandedColumns& columns, Eigen::Index scale, int limit, double factor) {
    for (Eigen::Index part = 0; part < parts; ++part) {
      const MatrixX& values = part == 0 ? columns.plain.values : columns.centred[static_cast<std::size_t>(part - 1)];
      rows.block(block.begin, limit_column(part, limit), block.count, 1) =
          factor * values.col(scale).cwiseQuotient(block.scales);
      block.magnitudes[limit_column(part, limit)] = std::abs(factor) * columns.plain.magnitudes[scale];
    }
  }

  bool add_heights(int counterweight, int corner, const ExpandedColumns& columns, std::optional<double> mass) {
    Block block;
    block.counterweight = counterweight;
    block.corner = corner;
    block.count = columns.plain.values.rows();
    block.scales = columns.plain.values.col(0);
    if (!(numerics::min_coefficient(block.scales) > 0)) return false;
    block.shape = {columns.plain.variables, columns.plain.degrees, {}, {}};
    block.magnitudes = VectorX::Zero(size);
    block.constant_magnitude = columns.plain.magnitudes[0];
    Block& added = add_block(std::move(block));
    set_w(added, columns, 1, 1);
    if (mass) set_limit(added, columns, 0, limit_index[static_cast<std::size_t>(counterweight)], 1 / *mass);
    right.segment(added.begin, added.count).setOnes();
    return true;
  }

  /// σ ≤ 0 at all corners of the box of affine lengths.
  void add_signs(int counterweight) {
    Block block;
    block.kind = Kind::sign;
    block.counterweight = counterweight;
    block.count = Eigen::Index(1) << (parts - 1);
    block.scales = VectorX::Ones(block.count);
    block.magnitudes = VectorX::Zero(size);
    const Block& added = add_block(std::move(block));
    for (Eigen::Index r = 0; r < added.count; ++r)
      for (Eigen::Index part = 0; part < parts; ++part)
        rows(added.begin + r, limit_column(part, limit_index[static_cast<std::size_t>(counterweight)])) =
            part == 0 || ((r >> (part - 1)) & 1) != 0 ? 1 : -1;
    right.segment(added.begin, added.count).setZero();
  }

  bool add_objective(const ExpandedColumns& columns) {
    Block block;
    block.kind = Kind::objective;
    block.count = columns.plain.values.rows();
    block.scales = columns.plain.values.col(1);
    if (!(numerics::min_coefficient(block.scales) > 0)) return false;
    block.shape = {columns.plain.variables, columns.plain.degrees, {}, {}};
    block.magnitudes = VectorX::Zero(size);
    block.constant_magnitude = columns.plain.magnitudes[0];
    Block& added = add_block(std::move(block));
    set_w(added, columns, 2, 1);
    for (Eigen::Index limit = 0; limit < limits; ++limit) set_limit(added, columns, 1, static_cast<int>(limit), -1);
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      const Eigen::Index column = 2 + unknowns + conditions[i];
      rows.block(added.begin, condition_column(i), added.count, 1) =
          columns.plain.values.col(column).cwiseQuotient(added.scales);
      added.magnitudes[condition_column(i)] = columns.plain.magnitudes[column];
    }
    rows.block(added.begin, bound_column(), added.count, 1).setOnes();
    right.segment(added.begin, added.count) = columns.plain.values.col(0).cwiseQuotient(added.scales);
    return true;
  }

  /// γ has no bound but those of the others.
  void add_multiplier_bounds() {
    const Eigen::Index first = count;
    reserve(2 * (size - 1));
    rows.middleRows(first, 2 * (size - 1)).setZero();
    for (Eigen::Index j = 0; j + 1 < size; ++j) {
      rows(first + 2 * j, j) = 1;
      rows(first + 2 * j + 1, j) = -1;
    }
    right.segment(first, 2 * (size - 1)).setConstant(max_multiplier);
    for (std::size_t i = 0; i < conditions.size(); ++i)
      if (!is_equality[i]) right[first + 2 * condition_column(i) + 1] = 0;
    count += 2 * (size - 1);
  }

  VectorX round_off(const Block& block, const VectorX& x) const {
    const double sum = block.magnitudes.dot(x.cwiseAbs()) + block.constant_magnitude;
    const double relative = bernstein_round_off + static_cast<double>(size) * std::numeric_limits<double>::epsilon();
    return (relative * sum) * block.scales.cwiseInverse();
  }

  /// Makes x a certificate, and its last entry the bound that it proves.
  void repair(VectorX& x) const {
    x[bound_column()] = 0;
    for (std::size_t i = 0; i < conditions.size(); ++i)
      if (!is_equality[i]) x[condition_column(i)] = std::max(x[condition_column(i)], 0.0);
    for (const Block& block : blocks) {
      if (block.kind != Kind::sign) continue;
      // homogeneous: shifted instead of scaled
      const int limit = limit_index[static_cast<std::size_t>(block.counterweight)];
      double size_sum = 0;
      for (Eigen::Index part = 0; part < parts; ++part) size_sum += std::abs(x[limit_column(part, limit)]);
      const double excess = numerics::max_coefficient(rows.middleRows(block.begin, block.count) * x);
      x[limit_column(0, limit)] -= std::max(excess + bernstein_round_off * size_sum, 0.0);
    }
    double violation = 0;
    for (const Block& block : blocks) {
      if (block.kind != Kind::height) continue;
      const VectorX excess =
          rows.middleRows(block.begin, block.count) * x - right.segment(block.begin, block.count) + round_off(block, x);
      violation = std::max(violation, numerics::max_coefficient(excess));
    }
    x /= 1 + violation;
    const Block& objective = blocks.back();
    x[bound_column()] =
        numerics::min_coefficient(right.segment(objective.begin, objective.count) -
                                  rows.middleRows(objective.begin, objective.count) * x - round_off(objective, x));
  }

  /// Weight of the active rows that want each length small or large, by the change of their slack along it.
  MatrixX measure_conflict(const VectorX& slack, const VectorX& multipliers, Eigen::Index lengths) const {
    MatrixX conflict = MatrixX::Zero(lengths, 2);
    for (const Block& block : blocks) {
      if (block.kind == Kind::sign) continue;
      for (std::size_t a = 0; a < block.shape.variables.size(); ++a) {
        const int degree = block.shape.degrees[a];
        if (degree == 0) continue;
        Eigen::Index step = 1;
        for (std::size_t b = a + 1; b < block.shape.degrees.size(); ++b) step *= block.shape.degrees[b] + 1;
        for (Eigen::Index r = 0; r < block.count; ++r) {
          const double multiplier = multipliers[block.begin + r];
          if (multiplier < min_active_multiplier) continue;
          const Eigen::Index index = r / step % (degree + 1), first = block.begin + r - index * step;
          double span = 0;
          for (Eigen::Index i = 1; i <= degree; ++i)
            span = std::max(span, std::abs(slack[first + i * step] - slack[first]));
          const double position = static_cast<double>(index) / degree;
          conflict(block.shape.variables[a], 0) += multiplier * (1 - position) * span;
          conflict(block.shape.variables[a], 1) += multiplier * position * span;
        }
      }
    }
    return conflict;
  }
};

BoxProgram::BoxProgram(const PlanarLinkage& linkage, const VirtualLinkage& dual,
                       std::vector<LengthCondition> conditions)
    : linkage_(linkage),
      dual_(dual),
      conditions_(std::move(conditions)),
      objective_(list_objective(dual, conditions_)) {
  std::vector<bool> occurs(static_cast<std::size_t>(linkage.variables), false);
  const auto note = [&](const BernsteinForm& form) {
    for (const int variable : form.variables()) occurs[static_cast<std::size_t>(variable)] = true;
  };
  note(objective_);
  for (const auto& counterweight : dual.corners) {
    auto& forms = corners_.emplace_back();
    for (const VirtualHeight& height : counterweight) {
      forms.emplace_back(list_polynomials(height));
      note(forms.back());
    }
  }
  for (const LengthPolynomial& p : dual.positive) positive_.emplace_back(std::vector<LengthPolynomial>{p});
  for (std::size_t i = 0; i < occurs.size(); ++i)
    if (occurs[i]) lengths_.push_back(static_cast<int>(i));
}

std::vector<int> BoxProgram::find_active_conditions(const LengthBox& box) const {
  std::vector<int> active;
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    if (conditions_[i].is_equality || enclose_range(conditions_[i].polynomial, box).first < 0)
      active.push_back(static_cast<int>(i));
  return active;
}

bool BoxProgram::has_positive_scales(const LengthBox& box) const {
  return std::all_of(positive_.begin(), positive_.end(), [&](const BernsteinForm& form) {
    const BernsteinCoefficients coefficients = form.convert(box);
    return numerics::min_coefficient(coefficients.values) > bernstein_round_off * coefficients.magnitudes[0];
  });
}

std::vector<MassLimits> list_mass_limits(const PlanarLinkage& linkage) {
  std::vector<MassLimits> limits;
  for (const FreeCounterweight& counterweight : linkage.counterweights)
    limits.push_back({counterweight.lower, counterweight.upper, false});
  return limits;
}

BoxBound BoxProgram::bound(const LengthBox& box, const std::vector<int>& affine,
                           std::vector<MassLimits>& limits) const {
  for (;;) {
    BoxBound result = solve(box, affine, limits);
    bool has_new_limit = false;
    for (std::size_t i = 0; i < result.corner_masses.size(); ++i) {
      if (limits[i].is_upper_used || result.mass(i) <= limits[i].upper * (1 + mass_limit_tolerance)) continue;
      limits[i].is_upper_used = has_new_limit = true;
    }
    if (!has_new_limit) return result;
  }
}

BoxBound BoxProgram::solve(const LengthBox& box, const std::vector<int>& affine,
                           const std::vector<MassLimits>& limits) const {
  const std::size_t counterweights = corners_.size();
  BoxBound result;
  Assembly rows;
  rows.unknowns = dual_.unknowns;
  rows.parts = 1 + static_cast<Eigen::Index>(affine.size());
  rows.limits = 0;
  for (const MassLimits& limit : limits) {
    const bool has_limit = !limit.is_left_out() && (limit.is_upper_used || limit.lower > 0);
    rows.limit_index.push_back(has_limit ? static_cast<int>(rows.limits++) : -1);
  }
  rows.conditions = find_active_conditions(box);
  for (const int condition : rows.conditions)
    rows.is_equality.push_back(conditions_[static_cast<std::size_t>(condition)].is_equality);
  rows.size = rows.parts * (rows.unknowns + rows.limits) + static_cast<Eigen::Index>(rows.conditions.size()) + 1;
  rows.rows.resize(64, rows.size);
  rows.right.resize(64);
  bool is_sound = true;
  for (std::size_t i = 0; i < counterweights; ++i) {
    const MassLimits& limit = limits[i];
    if (limit.is_left_out()) continue;
    const auto index = static_cast<int>(i);
    for (std::size_t c = 0; c < corners_[i].size(); ++c) {
      const ExpandedColumns columns = expand(corners_[i][c].convert(box), affine);
      const auto corner = static_cast<int>(c);
      std::vector<std::optional<double>> masses;
      if (limit.lower > 0) masses.emplace_back(limit.lower);
      if (!limit.is_upper_used)
        masses.emplace_back();
      else if (limit.upper > limit.lower)
        masses.emplace_back(limit.upper);
      for (const std::optional<double>& mass : masses)
        is_sound = is_sound && rows.add_heights(index, corner, columns, mass);
    }
    if (limit.is_upper_used && limit.lower <= 0) rows.add_signs(index);
  }
  is_sound = is_sound && rows.add_objective(expand(objective_.convert(box), affine));
  if (!is_sound) return result;
  rows.add_multiplier_bounds();
  VectorX gain = VectorX::Zero(rows.size);
  gain[rows.bound_column()] = 1;
  const numerics::InequalityProgramSolution solution =
      numerics::solve_inequality_program(gain, rows.rows.topRows(rows.count), rows.right.head(rows.count));
  if (solution.status != numerics::LinearProgramStatus::optimal || !solution.x.allFinite()) return result;
  VectorX x = solution.x;
  const VectorX slack = rows.right.head(rows.count) - rows.rows.topRows(rows.count) * x;
  rows.repair(x);
  result.bound = x[rows.bound_column()];
  result.conflict = rows.measure_conflict(slack, solution.multipliers, linkage_.variables);
  for (std::size_t i = 0; i < counterweights; ++i)
    result.corner_masses.push_back(VectorX::Zero(static_cast<Eigen::Index>(corners_[i].size())));
  for (const Assembly::Block& block : rows.blocks)
    if (block.kind == Assembly::Kind::height)
      result.corner_masses[static_cast<std::size_t>(block.counterweight)][block.corner] +=
          solution.multipliers.segment(block.begin, block.count).sum();
  result.certificate = {affine, limits, rows.limit_index, {}, dual_.unknowns, rows.conditions, {}};
  result.certificate.condition_multipliers.resize(static_cast<Eigen::Index>(rows.conditions.size()));
  for (std::size_t i = 0; i < rows.conditions.size(); ++i)
    result.certificate.condition_multipliers[static_cast<Eigen::Index>(i)] = x[rows.condition_column(i)];
  result.certificate.multipliers.resize(rows.parts, rows.unknowns + rows.limits);
  for (Eigen::Index part = 0; part < rows.parts; ++part) {
    for (Eigen::Index w = 0; w < rows.unknowns; ++w)
      result.certificate.multipliers(part, w) = x[rows.w_column(part, w)];
    for (Eigen::Index limit = 0; limit < rows.limits; ++limit)
      result.certificate.multipliers(part, rows.unknowns + limit) = x[rows.limit_column(part, limit)];
  }
  return result;
}

}  // namespace balance::certificate
