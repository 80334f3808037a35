#include "balance/synthesis/certificate/box_program.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/inequality_program.hpp"
#include "balance/synthesis/certificate/placed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::certificate {
namespace {

/// Relative: a mass above its limit by less is round-off of the solver.
constexpr double mass_limit_tolerance = 1e-9;
constexpr double min_active_multiplier = 1e-12;
/// Of heights, which are at most 1: places that are higher by less are not added. The rest costs tightness.
constexpr double height_tolerance = 1e-10;
constexpr int max_place_rounds = 24;
/// Of maxima over places, whose vertices are rounded as well.
constexpr double place_round_off_factor = 4;

std::vector<LengthPolynomial> list_polynomials(const VirtualHeight& height) {
  std::vector<LengthPolynomial> all{height.scale};
  all.insert(all.end(), height.coefficients.begin(), height.coefficients.end());
  return all;
}

std::vector<LengthPolynomial> list_polynomials(const PlacedHeight& height, int unknowns) {
  std::vector<LengthPolynomial> all{height.scale};
  for (const auto& coefficients : height.coefficients)
    for (std::size_t w = 0; w < static_cast<std::size_t>(unknowns); ++w)
      all.push_back(coefficients.empty() ? LengthPolynomial() : coefficients[w]);
  return all;
}

std::vector<LengthPolynomial> list_objective(const VirtualLinkage& dual,
                                             const std::vector<LengthCondition>& conditions) {
  std::vector<LengthPolynomial> all = list_polynomials(dual.fixed_masses);
  all.insert(all.begin(), dual.fixed_size);
  for (const LengthCondition& condition : conditions) all.push_back(condition.polynomial);
  return all;
}

}  // namespace

/// The rows of a box's program, each divided by its scale so that its right-hand side is 1 (0 for signs of σ).
struct BoxProgram::Assembly {
  enum class Kind { height, inertia, sign, objective };
  struct Block {
    Kind kind = Kind::height;
    int counterweight = -1, corner = -1;
    int inertia = -1, limit = -1;  ///< of an inertia; the σ of a sign or an inertia
    double ratio = 0, amount = 1;  ///< of an inertia; its limit
    Eigen::Index begin = 0, count = 0;
    BernsteinCoefficients shape;  ///< without values: the indices of the rows
    VectorX scales;               ///< per row
    VectorX magnitudes;           ///< per unknown: bound on absolute terms, before the division by the scale
    double constant_magnitude = 0;
  };

  Eigen::Index unknowns, limits, parts, size;  ///< w, σ, 1 + affine lengths; all with κ and γ
  std::vector<int> conditions;                 ///< that take part
  std::vector<bool> is_equality;
  std::vector<int> limit_index;  ///< per counterweight, then per inertia
  MatrixX rows;
  VectorX right;
  Eigen::Index count = 0;
  std::vector<Block> blocks;
  std::size_t objective = 0;  ///< into blocks

  /// A counterweight with moments, and the mass limits that its rows use; none: any mass.
  struct Placed {
    const PlacedRows* rows;
    int counterweight;
    std::vector<std::optional<double>> masses;
    std::vector<Vector3>* places;  ///< with rows
  };
  std::vector<Placed> placed;

  Eigen::Index w_column(Eigen::Index part, Eigen::Index w) const { return part * unknowns + w; }
  Eigen::Index limit_column(Eigen::Index part, Eigen::Index limit) const {
    return parts * unknowns + part * limits + limit;
  }
  Eigen::Index condition_column(std::size_t index) const {
    return parts * (unknowns + limits) + static_cast<Eigen::Index>(index);
  }
  Eigen::Index bound_column() const { return size - 1; }

  /// Columns of a program without rows.
  void prepare(const BoxProgram& program, const LengthBox& box, std::size_t affine_count,
               const std::vector<MassLimits>& mass_limits);
  /// @return false: a scale is not positive on the box
  bool add_counterweights(const BoxProgram& program, const LengthBox& box, const std::vector<int>& affine,
                          const std::vector<MassLimits>& mass_limits, const std::vector<PlacedRows>& placed_rows,
                          std::vector<std::vector<Vector3>>& places);
  bool add_inertias(const BoxProgram& program, const std::vector<PlacedRows>& placed_rows);
  /// Masses and inertias of the relaxation, which are the multipliers of the rows.
  void store_masses(const VectorX& multipliers, BoxBound& result) const;
  void store_certificate(const VectorX& x, BoxCertificate& certificate) const;

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

  /// A row per Bernstein coefficient, whose scale is the first column.
  Block make_block(const ExpandedColumns& columns) const {
    Block block;
    block.count = columns.plain.values.rows();
    block.scales = columns.plain.values.col(0);
    block.shape = {columns.plain.variables, columns.plain.degrees, {}, {}};
    block.magnitudes = VectorX::Zero(size);
    return block;
  }

  bool add_heights(int counterweight, int corner, const ExpandedColumns& columns, std::optional<double> mass) {
    Block block = make_block(columns);
    if (!(numerics::min_coefficient(block.scales) > 0)) return false;
    block.counterweight = counterweight;
    block.corner = corner;
    block.constant_magnitude = columns.plain.magnitudes[0];
    Block& added = add_block(std::move(block));
    set_w(added, columns, 1, 1);
    if (mass) set_limit(added, columns, 0, limit_index[static_cast<std::size_t>(counterweight)], 1 / *mass);
    right.segment(added.begin, added.count).setOnes();
    return true;
  }

  /// h + σ / amount ≤ 0
  bool add_inertia(int inertia, int limit, const PlacedRows& placed_rows, double ratio, double amount) {
    const ExpandedColumns columns = placed_rows.at({0, 0, ratio});
    Block block = make_block(columns);
    if (!(numerics::min_coefficient(block.scales) > 0)) return false;
    block.kind = Kind::inertia;
    block.inertia = inertia;
    block.limit = limit;
    block.ratio = ratio;
    block.amount = amount;
    Block& added = add_block(std::move(block));
    set_w(added, columns, 1, 1);
    set_limit(added, columns, 0, limit, 1 / amount);
    right.segment(added.begin, added.count).setZero();
    return true;
  }

  /// Rows at a place, for all mass limits in use.
  bool add_place(const Placed& one, int place) {
    const ExpandedColumns columns = one.rows->at((*one.places)[static_cast<std::size_t>(place)]);
    return std::all_of(one.masses.begin(), one.masses.end(), [&](const std::optional<double>& mass) {
      return add_heights(one.counterweight, place, columns, mass);
    });
  }

  /// The constant part and those of the affine lengths.
  MatrixX w_of(const VectorX& x) const {
    MatrixX w(parts, unknowns);
    for (Eigen::Index part = 0; part < parts; ++part)
      for (Eigen::Index i = 0; i < unknowns; ++i) w(part, i) = x[w_column(part, i)];
    return w;
  }

  /// By how much heights, with σ, exceed 1 at their highest places: per Bernstein coefficient, the largest of all mass
  /// limits.
  VectorX find_excess(const Placed& one, const VectorX& x, const HighestPlaces& highest) const {
    const PlacedRows& own = *one.rows;
    const VectorX& scales = own.columns.plain.values.col(0);
    const VectorX w_magnitudes = own.magnitudes();
    const int limit = limit_index[static_cast<std::size_t>(one.counterweight)];
    VectorX shift = VectorX::Zero(scales.size());
    double size_sum = own.columns.plain.magnitudes[0], shift_sum = 0;
    for (Eigen::Index part = 0; part < parts; ++part) {
      for (Eigen::Index i = 0; i < unknowns; ++i) size_sum += w_magnitudes[i] * std::abs(x[w_column(part, i)]);
      if (limit < 0) continue;
      const MatrixX& values =
          part == 0 ? own.columns.plain.values : own.columns.centred[static_cast<std::size_t>(part - 1)];
      shift += values.col(0) * x[limit_column(part, limit)];
      shift_sum += own.columns.plain.magnitudes[0] * std::abs(x[limit_column(part, limit)]);
    }
    VectorX excess = VectorX::Constant(scales.size(), -1);
    for (const std::optional<double>& mass : one.masses) {
      const double share = mass ? 1 / *mass : 0;
      const double margin = place_round_off_factor * relative_round_off() * (size_sum + share * shift_sum);
      excess = excess.cwiseMax((highest.heights + share * shift.cwiseQuotient(scales)).array().matrix() -
                               VectorX::Ones(scales.size()) + margin * scales.cwiseInverse());
    }
    return excess;
  }

  /// Adds rows at the highest place of each counterweight that is too high, and at the centre of its masses in the
  /// relaxation, which is nearer to where the next solution has them. @return whether there are any
  bool add_high_places(const VectorX& x, const VectorX& multipliers) {
    const MatrixX w = w_of(x);
    bool has_added = false;
    for (const Placed& one : placed) {
      if (!one.rows->has_square) continue;
      const HighestPlaces highest = one.rows->find_highest(w);
      const VectorX excess = find_excess(one, x, highest);
      const Eigen::Index row = numerics::max_index(excess);
      if (excess[row] <= height_tolerance) continue;
      const Vector3 centre = find_centre(one, multipliers);
      for (const Vector3& place : {highest.places[static_cast<std::size_t>(row)], centre}) {
        if (std::find(one.places->begin(), one.places->end(), place) != one.places->end()) continue;
        one.places->push_back(place);
        has_added = add_place(one, static_cast<int>(one.places->size()) - 1) || has_added;
      }
    }
    return has_added;
  }

  /// Calls use(place, masses of its rows) for all places of a counterweight.
  template <class Use>
  void visit_places(const Placed& one, const VectorX& multipliers, const Use& use) const {
    for (const Block& block : blocks)
      if (block.kind == Kind::height && block.counterweight == one.counterweight)
        use((*one.places)[static_cast<std::size_t>(block.corner)],
            multipliers.segment(block.begin, block.count).cwiseMax(0.0));
  }

  /// Of its masses in the relaxation; without mass its first place.
  Vector3 find_centre(const Placed& one, const VectorX& multipliers) const {
    double mass = 0;
    Vector3 sum = Vector3::Zero();
    visit_places(one, multipliers, [&](const Vector3& place, const VectorX& masses) {
      mass += masses.sum();
      sum += masses.sum() * place;
    });
    return mass > 0 ? Vector3(sum / mass) : one.places->front();
  }

  /// σ ≤ 0 at all corners of the box of affine lengths.
  void add_signs(int limit) {
    Block block;
    block.kind = Kind::sign;
    block.limit = limit;
    block.count = Eigen::Index(1) << (parts - 1);
    block.scales = VectorX::Ones(block.count);
    block.magnitudes = VectorX::Zero(size);
    const Block& added = add_block(std::move(block));
    for (Eigen::Index r = 0; r < added.count; ++r)
      for (Eigen::Index part = 0; part < parts; ++part)
        rows(added.begin + r, limit_column(part, limit)) = part == 0 || ((r >> (part - 1)) & 1) != 0 ? 1 : -1;
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
    objective = blocks.size();
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
    return (relative_round_off() * sum) * block.scales.cwiseInverse();
  }

  double relative_round_off() const {
    return bernstein_round_off + static_cast<double>(size) * std::numeric_limits<double>::epsilon();
  }

  /// Makes x a certificate, and its last entry the bound that it proves.
  void repair(VectorX& x) const {
    x[bound_column()] = 0;
    for (std::size_t i = 0; i < conditions.size(); ++i)
      if (!is_equality[i]) x[condition_column(i)] = std::max(x[condition_column(i)], 0.0);
    for (const Block& block : blocks) {
      if (block.kind != Kind::sign && block.kind != Kind::inertia) continue;
      // homogeneous: shifted instead of scaled
      double size_sum = 0;
      for (Eigen::Index part = 0; part < parts; ++part) size_sum += std::abs(x[limit_column(part, block.limit)]);
      VectorX excess = rows.middleRows(block.begin, block.count) * x;
      if (block.kind == Kind::inertia) excess += 2 * round_off(block, x);
      x[limit_column(0, block.limit)] -=
          std::max(block.amount * numerics::max_coefficient(excess) + bernstein_round_off * size_sum, 0.0);
    }
    double violation = 0;
    const MatrixX w = w_of(x);
    for (const Placed& one : placed)
      violation = std::max(violation, numerics::max_coefficient(find_excess(one, x, one.rows->find_highest(w))));
    for (const Block& block : blocks) {
      if (block.kind != Kind::height || !placed.empty()) continue;
      const VectorX excess =
          rows.middleRows(block.begin, block.count) * x - right.segment(block.begin, block.count) + round_off(block, x);
      violation = std::max(violation, numerics::max_coefficient(excess));
    }
    x /= 1 + violation;
    const Block& last = blocks[objective];
    x[bound_column()] = numerics::min_coefficient(right.segment(last.begin, last.count) -
                                                  rows.middleRows(last.begin, last.count) * x - round_off(last, x));
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

  /// A counterweight that the relaxation has at several places has the inertia of all of them: the weight of what a
  /// mass at one place lacks.
  void measure_spread(const VectorX& x, const VectorX& multipliers, MatrixX& conflict) const {
    const MatrixX w = w_of(x);
    for (const Placed& one : placed) {
      if (!one.rows->has_square) continue;
      const VectorX curvature = one.rows->evaluate(w).col(PlacedHeight::square).cwiseAbs();
      const Vector3 centre = find_centre(one, multipliers);
      visit_places(one, multipliers, [&](const Vector3& place, const VectorX& masses) {
        for (std::size_t i = 0; i < 2; ++i) {
          if (one.rows->numbers[i] < 0) continue;
          const auto axis = static_cast<Eigen::Index>(i);
          conflict.row(one.rows->numbers[i]).array() +=
              masses.dot(curvature) * (place[axis] - centre[axis]) * (place[axis] - centre[axis]);
        }
      });
    }
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
  const auto add_placed = [&](const std::vector<PlacedHeight>& heights, std::vector<BernsteinForm>& forms) {
    for (const PlacedHeight& height : heights) {
      forms.emplace_back(list_polynomials(height, dual.unknowns));
      note(forms.back());
    }
  };
  add_placed(dual.placed, placed_);
  add_placed(dual.inertias, inertias_);
  for (std::size_t i = 0; i < placed_.size(); ++i)
    for (const int number : linkage.counterweights[i].place_numbers)
      if (number >= 0 && !dual.placed[i].coefficients[PlacedHeight::square].empty()) places_.push_back(number);
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

Eigen::Index count_coefficients(const VirtualLinkage& dual, const std::vector<LengthCondition>& conditions) {
  Eigen::Index count = count_coefficients(list_objective(dual, conditions));
  for (const auto* heights : {&dual.placed, &dual.inertias})
    for (const PlacedHeight& height : *heights)
      count = std::max(count, count_coefficients(list_polynomials(height, dual.unknowns)));
  return count;
}

LengthBox BoxProgram::point_box(const VectorX& lengths, const LengthBox& box) const {
  LengthBox point{lengths, lengths};
  std::vector<int> numbers = list_free_ratios(linkage_);
  for (const FreeCounterweight& counterweight : linkage_.counterweights)
    for (const int number : counterweight.place_numbers)
      if (number >= 0) numbers.push_back(number);
  for (const int number : numbers) {
    point.lower[number] = box.lower[number];
    point.upper[number] = box.upper[number];
  }
  return point;
}

std::map<int, double> BoxProgram::list_centres(const BoxBound& bound) const {
  std::map<int, double> centres;
  for (std::size_t i = 0; i < bound.places.size(); ++i) {
    const FreeCounterweight& counterweight = linkage_.counterweights[i];
    const VectorX& masses = bound.corner_masses[i];
    const double mass = masses.sum();
    if (!(mass > 0)) continue;
    Vector3 centre = Vector3::Zero();
    for (Eigen::Index c = 0; c < masses.size(); ++c)
      centre += masses[c] / mass * bound.places[i][static_cast<std::size_t>(c)];
    const std::array<int, 3> numbers{counterweight.place_numbers[0], counterweight.place_numbers[1],
                                     counterweight.spin.ratio_number};
    for (std::size_t k = 0; k < 3; ++k)
      if (numbers[k] >= 0) centres[numbers[k]] = centre[static_cast<Eigen::Index>(k)];
  }
  return centres;
}

std::vector<PlacedRows> BoxProgram::list_placed_rows(const LengthBox& box, const std::vector<int>& affine) const {
  std::vector<PlacedRows> all;
  const bool is_point = affine.empty() && std::all_of(lengths_.begin(), lengths_.end(), [&](int length) {
                          return box.lower[length] == box.upper[length];
                        });
  const auto add = [&](const BernsteinForm& form, const std::array<int, 3>& numbers) -> PlacedRows& {
    PlacedRows& rows = all.emplace_back();
    BernsteinCoefficients coefficients = form.convert(box);
    if (is_point) {  // all of them are the polynomial's value
      coefficients.values = coefficients.values.topRows(1).eval();
      std::fill(coefficients.degrees.begin(), coefficients.degrees.end(), 0);
    }
    rows.columns = expand(coefficients, affine);
    rows.unknowns = dual_.unknowns;
    rows.numbers = numbers;
    for (std::size_t i = 0; i < 3; ++i) {
      if (numbers[i] < 0) continue;
      const auto axis = static_cast<Eigen::Index>(i);
      rows.lower[axis] = box.lower[numbers[i]];
      rows.upper[axis] = box.upper[numbers[i]];
    }
    return rows;
  };
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const FreeCounterweight& counterweight = linkage_.counterweights[i];
    add(placed_[i], {counterweight.place_numbers[0], counterweight.place_numbers[1], counterweight.spin.ratio_number})
        .has_square = !dual_.placed[i].coefficients[PlacedHeight::square].empty();
  }
  for (std::size_t i = 0; i < inertias_.size(); ++i)
    add(inertias_[i], {-1, -1, linkage_.inertias[i].spin.ratio_number});
  return all;
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

void BoxProgram::Assembly::prepare(const BoxProgram& program, const LengthBox& box, std::size_t affine_count,
                                   const std::vector<MassLimits>& mass_limits) {
  unknowns = program.dual_.unknowns;
  parts = 1 + static_cast<Eigen::Index>(affine_count);
  limits = 0;
  for (const MassLimits& limit : mass_limits) {
    const bool has_limit = !limit.is_left_out() && (limit.is_upper_used || limit.lower > 0);
    limit_index.push_back(has_limit ? static_cast<int>(limits++) : -1);
  }
  for (std::size_t i = 0; i < program.inertias_.size(); ++i) limit_index.push_back(static_cast<int>(limits++));
  conditions = program.find_active_conditions(box);
  for (const int condition : conditions)
    is_equality.push_back(program.conditions_[static_cast<std::size_t>(condition)].is_equality);
  size = parts * (unknowns + limits) + static_cast<Eigen::Index>(conditions.size()) + 1;
  rows.resize(64, size);
  right.resize(64);
}

bool BoxProgram::Assembly::add_counterweights(const BoxProgram& program, const LengthBox& box,
                                              const std::vector<int>& affine,
                                              const std::vector<MassLimits>& mass_limits,
                                              const std::vector<PlacedRows>& placed_rows,
                                              std::vector<std::vector<Vector3>>& places) {
  bool is_sound = true;
  for (std::size_t i = 0; i < mass_limits.size(); ++i) {
    const MassLimits& limit = mass_limits[i];
    if (limit.is_left_out()) continue;
    const auto index = static_cast<int>(i);
    std::vector<std::optional<double>> masses;
    if (limit.lower > 0) masses.emplace_back(limit.lower);
    if (!limit.is_upper_used)
      masses.emplace_back();
    else if (limit.upper > limit.lower)
      masses.emplace_back(limit.upper);
    if (program.placed_.empty()) {
      for (std::size_t c = 0; c < program.corners_[i].size(); ++c) {
        const ExpandedColumns columns = expand(program.corners_[i][c].convert(box), affine);
        for (const std::optional<double>& mass : masses)
          is_sound = is_sound && add_heights(index, static_cast<int>(c), columns, mass);
      }
    } else {
      places[i] = placed_rows[i].list_corners();
      placed.push_back({&placed_rows[i], index, masses, &places[i]});
      for (std::size_t c = 0; c < places[i].size(); ++c)
        is_sound = is_sound && add_place(placed.back(), static_cast<int>(c));
    }
    if (limit.is_upper_used && limit.lower <= 0) add_signs(limit_index[i]);
  }
  return is_sound;
}

bool BoxProgram::Assembly::add_inertias(const BoxProgram& program, const std::vector<PlacedRows>& placed_rows) {
  const std::size_t counterweights = program.linkage_.counterweights.size();
  bool is_sound = true;
  for (std::size_t i = 0; i < program.inertias_.size(); ++i) {
    const FreeInertia& inertia = program.linkage_.inertias[i];
    const PlacedRows& own = placed_rows[counterweights + i];
    const int limit = limit_index[counterweights + i];
    std::vector<double> amounts;
    if (inertia.lower > 0) amounts.push_back(inertia.lower);
    if (inertia.upper > inertia.lower) amounts.push_back(inertia.upper);
    for (const double amount : amounts)
      for (const Vector3& corner : own.list_corners())
        is_sound = is_sound && add_inertia(static_cast<int>(i), limit, own, corner[2], amount);
    if (inertia.lower <= 0) add_signs(limit);
  }
  return is_sound;
}

void BoxProgram::Assembly::store_masses(const VectorX& multipliers, BoxBound& result) const {
  for (const Block& block : blocks) {
    const double amount = multipliers.segment(block.begin, block.count).sum();
    if (block.kind == Kind::height)
      result.corner_masses[static_cast<std::size_t>(block.counterweight)][block.corner] += amount;
    if (block.kind != Kind::inertia) continue;
    result.inertias[static_cast<std::size_t>(block.inertia)] += amount;
    result.ratios[static_cast<std::size_t>(block.inertia)] += amount * block.ratio;
  }
  for (std::size_t i = 0; i < result.inertias.size(); ++i)
    if (result.inertias[i] > 0) result.ratios[i] /= result.inertias[i];
}

void BoxProgram::Assembly::store_certificate(const VectorX& x, BoxCertificate& certificate) const {
  certificate.limit_index = limit_index;
  certificate.unknowns = static_cast<int>(unknowns);
  certificate.conditions = conditions;
  certificate.condition_multipliers.resize(static_cast<Eigen::Index>(conditions.size()));
  for (std::size_t i = 0; i < conditions.size(); ++i)
    certificate.condition_multipliers[static_cast<Eigen::Index>(i)] = x[condition_column(i)];
  certificate.multipliers.resize(parts, unknowns + limits);
  for (Eigen::Index part = 0; part < parts; ++part) {
    for (Eigen::Index w = 0; w < unknowns; ++w) certificate.multipliers(part, w) = x[w_column(part, w)];
    for (Eigen::Index limit = 0; limit < limits; ++limit)
      certificate.multipliers(part, unknowns + limit) = x[limit_column(part, limit)];
  }
}

BoxBound BoxProgram::solve(const LengthBox& box, const std::vector<int>& affine,
                           const std::vector<MassLimits>& limits) const {
  const std::size_t counterweights = linkage_.counterweights.size();
  const std::vector<PlacedRows> placed_rows = list_placed_rows(box, affine);
  BoxBound result;
  result.places.resize(placed_.empty() ? 0 : counterweights);
  Assembly rows;
  rows.prepare(*this, box, affine.size(), limits);
  const bool is_sound = rows.add_counterweights(*this, box, affine, limits, placed_rows, result.places) &&
                        rows.add_inertias(*this, placed_rows) &&
                        rows.add_objective(expand(objective_.convert(box), affine));
  if (!is_sound) return result;
  rows.add_multiplier_bounds();
  VectorX gain = VectorX::Zero(rows.size);
  gain[rows.bound_column()] = 1;
  numerics::InequalityProgramSolution solution;
  for (int round = 0; round <= max_place_rounds; ++round) {
    solution = numerics::solve_inequality_program(gain, rows.rows.topRows(rows.count), rows.right.head(rows.count));
    if (solution.status != numerics::LinearProgramStatus::optimal || !solution.x.allFinite()) return result;
    if (round == max_place_rounds || !rows.add_high_places(solution.x, solution.multipliers)) break;
  }
  VectorX x = solution.x;
  const VectorX slack = rows.right.head(rows.count) - rows.rows.topRows(rows.count) * x;
  rows.repair(x);
  result.bound = x[rows.bound_column()];
  result.conflict = rows.measure_conflict(slack, solution.multipliers, linkage_.variables);
  rows.measure_spread(x, solution.multipliers, result.conflict);
  for (std::size_t i = 0; i < counterweights; ++i)
    result.corner_masses.push_back(
        VectorX::Zero(static_cast<Eigen::Index>(placed_.empty() ? corners_[i].size() : result.places[i].size())));
  result.inertias.assign(inertias_.size(), 0);
  result.ratios.assign(inertias_.size(), 0);
  rows.store_masses(solution.multipliers, result);
  result.certificate.affine = affine;
  result.certificate.mass_limits = limits;
  rows.store_certificate(x, result.certificate);
  return result;
}

}  // namespace balance::certificate
