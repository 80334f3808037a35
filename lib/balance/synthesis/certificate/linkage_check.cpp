#include "balance/synthesis/certificate/linkage_check.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace balance::certificate {
namespace {

/// Relative: both are solved to about 1e-10. With moments, the heights between places cost more of the bound.
constexpr double agreement_tolerance = 1e-9, moment_agreement_tolerance = 1e-6;
/// Relative to the largest entry of the conditions.
constexpr double entry_round_off = 1e-14;
/// Of the conditions' rows with length 1: the library's accuracy, with a margin.
constexpr double rank_tolerance = 1e-8, row_tolerance = 1e-7;
constexpr int compared_lengths = 3;
constexpr int max_trials = 60;

/// Those whose conditions the linkage has.
std::vector<Goal> goals_of(const DesignSpace& space, const PlanarLinkage& linkage) {
  const std::vector<Goal>& goals = space.start.design.goals;
  std::vector<Goal> result;
  if (linkage.balances_forces)
    result.push_back(
        {std::any_of(goals.begin(), goals.end(), study::requires_zero_momentum) ? GoalKind::force : GoalKind::statics});
  if (linkage.balances_moments) result.push_back({GoalKind::moment});
  return result;
}

/// A unit of a counterweight or an inertia.
struct Sample {
  std::size_t element = 0;          ///< of the counterweights, then the inertias
  std::size_t corner = 0;           ///< without moments
  Vector3 place = Vector3::Zero();  ///< with moments: its free coordinates
};

/// Corners of places; with moments also middles, because heights are quadratic.
std::vector<Sample> list_samples(const DesignSpace& space, const PlanarLinkage& linkage) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < linkage.counterweights.size(); ++i) {
    const FreeCounterweight& counterweight = linkage.counterweights[i];
    if (!linkage.balances_moments) {
      for (std::size_t corner = 0; corner < counterweight.corners.size(); ++corner)
        samples.push_back({i, corner, Vector3::Zero()});
      continue;
    }
    std::vector<Vector3> places{Vector3::Zero()};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (counterweight.place_numbers[axis] < 0) continue;
      const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(counterweight.place_numbers[axis])];
      std::vector<Vector3> more;
      for (const Vector3& place : places)
        for (const double value : {free.lower, (free.lower + free.upper) / 2, free.upper}) {
          more.push_back(place);
          more.back()[static_cast<Eigen::Index>(axis)] = value;
        }
      places = std::move(more);
    }
    for (const Vector3& place : places) samples.push_back({i, 0, place});
  }
  for (std::size_t i = 0; i < linkage.inertias.size(); ++i)
    samples.push_back({linkage.counterweights.size() + i, 0, Vector3::Zero()});
  return samples;
}

/// The conditions of the library at given lengths and ratios, for amounts of the samples.
struct SampleConditions {
  MatrixX matrix;  ///< conditions × samples
  VectorX right;   ///< matrix · amounts = right
  std::vector<Sample> samples;
};

/// The mechanism at given lengths and ratios with one unit of a sample and none of the others.
class SampledMechanism {
 public:
  SampledMechanism(const DesignSpace& space, const PlanarLinkage& linkage, const VectorX& x)
      : space_(space), linkage_(linkage), x_(x) {
    for (const FreeCounterweight& counterweight : linkage.counterweights) {
      if (counterweight.mass_number >= 0) x_[counterweight.mass_number] = 0;
      for (const int number : counterweight.place_numbers)
        if (number >= 0) x_[number] = space.start.free_numbers[static_cast<std::size_t>(number)].lower;
    }
    for (const FreeInertia& inertia : linkage.inertias)
      if (inertia.number >= 0) x_[inertia.number] = 0;
  }

  /// @return none if it cannot be assembled
  std::optional<Mechanism> empty() const {
    const study::DesignInstance instance = space_.instantiate(x_);
    if (!instance.mode_issue.empty()) return {};
    Mechanism mechanism = instance.mechanism;
    for (const FreeCounterweight& counterweight : linkage_.counterweights) {
      if (counterweight.disc >= 0)
        disc_of(counterweight, mechanism).mass = 0;
      else
        attachment_of(counterweight, mechanism).mass = 0;
    }
    for (const FreeInertia& inertia : linkage_.inertias)
      if (inertia.number < 0) mechanism.discs[static_cast<std::size_t>(inertia.disc)].inertia.setZero();
    return mechanism;
  }

  /// @param empty as above
  Mechanism load(const Sample& sample, const Mechanism& empty) const {
    VectorX numbers = x_;
    Mechanism loaded = empty;
    if (sample.element >= linkage_.counterweights.size()) {
      const FreeInertia& inertia = linkage_.inertias[sample.element - linkage_.counterweights.size()];
      if (inertia.number >= 0) numbers[inertia.number] = 1;
      const Mechanism unit = space_.instantiate(numbers).mechanism;
      if (inertia.number < 0) {
        const auto disc = static_cast<std::size_t>(inertia.disc);
        loaded.discs[disc].inertia = unit.discs[disc].inertia;
        return loaded;
      }
      for (std::size_t k = 0; k < unit.bodies.size(); ++k) loaded.bodies[k].inertia = unit.bodies[k].inertia;
      for (std::size_t a = 0; a < unit.attachments.size(); ++a)
        loaded.attachments[a].inertia = unit.attachments[a].inertia;
      for (std::size_t d = 0; d < unit.discs.size(); ++d)
        if (static_cast<int>(d) == inertia.disc) loaded.discs[d].inertia = unit.discs[d].inertia;
      return loaded;
    }
    const FreeCounterweight& counterweight = linkage_.counterweights[sample.element];
    for (std::size_t i = 0; i < 2 && linkage_.balances_moments; ++i)
      if (counterweight.place_numbers[i] >= 0)
        numbers[counterweight.place_numbers[i]] = sample.place[static_cast<Eigen::Index>(i)];
    if (counterweight.mass_number >= 0) numbers[counterweight.mass_number] = 1;
    Mechanism unit = space_.instantiate(numbers).mechanism;
    if (counterweight.disc >= 0)
      place(disc_of(counterweight, unit), counterweight, sample, disc_of(counterweight, loaded));
    else
      place(attachment_of(counterweight, unit), counterweight, sample, attachment_of(counterweight, loaded));
    return loaded;
  }

 private:
  static Disc& disc_of(const FreeCounterweight& counterweight, Mechanism& mechanism) {
    return mechanism.discs[static_cast<std::size_t>(counterweight.disc)];
  }
  static Attachment& attachment_of(const FreeCounterweight& counterweight, Mechanism& mechanism) {
    return mechanism.attachments[static_cast<std::size_t>(counterweight.attachment)];
  }

  template <class Carried>
  void place(const Carried& unit, const FreeCounterweight& counterweight, const Sample& sample, Carried& loaded) const {
    const Matrix3 inertia = loaded.inertia;
    loaded = unit;
    loaded.mass = 1;
    const RatioSpin& spin = counterweight.spin;
    if (spin.constant.empty() && spin.per_ratio.empty()) loaded.inertia = inertia;  // not in proportion to the mass
    if (linkage_.balances_moments) return;
    // corners are measured from the tree joint; differences are the same from the body's origin
    const auto shift = (counterweight.corners[sample.corner].evaluate(x_) - counterweight.corners[0].evaluate(x_)) /
                       linkage_.turns[static_cast<std::size_t>(counterweight.body)];
    loaded.position[0] += shift.real();
    loaded.position[1] += shift.imag();
  }

  const DesignSpace& space_;
  const PlanarLinkage& linkage_;
  VectorX x_;
};

/// Removes what is round-off beside the largest entry: rows of nothing else would be made as large as the others.
void remove_round_off(MatrixX& entries) {
  const double negligible = entry_round_off * numerics::max_abs(entries);
  entries = (entries.array().abs() <= negligible).select(0.0, entries);
}

/// @return none if the mechanism cannot be assembled or its conditions are not clear
std::optional<SampleConditions> derive_sample_conditions(const DesignSpace& space, const PlanarLinkage& linkage,
                                                         const VectorX& x, std::vector<Sample> samples) {
  const SampledMechanism sampled(space, linkage, x);
  const std::optional<Mechanism> empty = sampled.empty();
  if (!empty) return {};
  ConditionOptions options;
  options.about = find_moment_reference(space);
  const Conditions conditions = derive_conditions(*empty, goals_of(space, linkage), options);
  if (conditions.status != ConditionsStatus::done || conditions.known_term_values.size() > 0) return {};
  const VectorX base = conditions::term_values(*empty);
  SampleConditions result;
  result.right = -(conditions.matrix * base);
  result.matrix.resize(conditions.matrix.rows(), static_cast<Eigen::Index>(samples.size()));
  for (std::size_t c = 0; c < samples.size(); ++c)
    result.matrix.col(static_cast<Eigen::Index>(c)) =
        conditions.matrix * (conditions::term_values(sampled.load(samples[c], *empty)) - base);
  remove_round_off(result.matrix);
  result.samples = std::move(samples);
  return result;
}

std::optional<double> find_min_mass(const SampleConditions& conditions, const PlanarLinkage& linkage,
                                    const VectorX& x) {
  const Eigen::Index count = conditions.matrix.cols();
  const std::size_t counterweights = linkage.counterweights.size();
  const auto element = [&](Eigen::Index c) { return conditions.samples[static_cast<std::size_t>(c)].element; };
  numerics::LinearProgram program(count);
  program.lower.setZero();
  for (Eigen::Index c = 0; c < count; ++c) program.cost[c] = element(c) < counterweights ? 1 : 0;
  for (Eigen::Index r = 0; r < conditions.matrix.rows(); ++r) {
    const VectorX row = conditions.matrix.row(r).transpose();
    const double scale = std::max(numerics::max_abs(row), std::abs(conditions.right[r]));
    if (scale == 0) continue;
    program.add_row(conditions.right[r] / scale, row / scale, conditions.right[r] / scale);
  }
  for (std::size_t i = 0; i < counterweights + linkage.inertias.size(); ++i) {
    VectorX row(count);
    for (Eigen::Index c = 0; c < count; ++c) row[c] = element(c) == i ? 1 : 0;
    const auto add_limits = [&](const auto& one) { program.add_row(one.lower, row, one.upper); };
    if (i < counterweights)
      add_limits(linkage.counterweights[i]);
    else
      add_limits(linkage.inertias[i - counterweights]);
  }
  const numerics::LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status == numerics::LinearProgramStatus::infeasible) return std::numeric_limits<double>::infinity();
  if (solution.status != numerics::LinearProgramStatus::optimal) return {};
  return program.cost.dot(solution.x) + linkage.fixed_size.evaluate(x).real();
}

/// Orthonormal basis of the rows, which are made comparable first.
MatrixX row_basis(MatrixX rows) {
  remove_round_off(rows);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const double size = rows.row(r).norm();
    if (size > 0) rows.row(r) /= size;
  }
  const numerics::SingularValueDecomposition svd(rows, Eigen::ComputeThinV);
  const VectorX& values = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > rank_tolerance * values[0]) ++rank;
  return svd.matrixV().leftCols(rank).transpose();
}

/// Value of coefficients · unknown j, divided by the scale.
double height_at(const LengthPolynomial& scale, const std::vector<LengthPolynomial>& coefficients, std::size_t unknown,
                 const VectorX& x) {
  return coefficients.empty() ? 0 : coefficients[unknown].evaluate(x).real() / scale.evaluate(x).real();
}

double height_of(const Sample& sample, const PlanarLinkage& linkage, const VirtualLinkage& dual, std::size_t unknown,
                 const VectorX& x) {
  if (!linkage.balances_moments) {
    const VirtualHeight& corner = dual.corners[sample.element][sample.corner];
    return height_at(corner.scale, corner.coefficients, unknown, x);
  }
  const std::size_t counterweights = linkage.counterweights.size();
  const bool is_inertia = sample.element >= counterweights;
  const PlacedHeight& placed =
      is_inertia ? dual.inertias[sample.element - counterweights] : dual.placed[sample.element];
  const RatioSpin& spin =
      is_inertia ? linkage.inertias[sample.element - counterweights].spin : linkage.counterweights[sample.element].spin;
  const std::array<double, PlacedHeight::count> functions{1, sample.place[0], sample.place[1],
                                                          sample.place.head<2>().squaredNorm(),
                                                          spin.ratio_number < 0 ? 0 : x[spin.ratio_number]};
  double height = 0;
  for (std::size_t f = 0; f < PlacedHeight::count; ++f)
    height += functions[f] * height_at(placed.scale, placed.coefficients[f], unknown, x);
  return height;
}

/// Whether the virtual heights of samples and fixed masses, per unknown, are combinations of the library's conditions
/// and conversely.
bool has_same_rows(const SampleConditions& conditions, const PlanarLinkage& linkage, const VirtualLinkage& dual,
                   const VectorX& x) {
  const Eigen::Index count = conditions.matrix.cols();
  MatrixX own(dual.unknowns, count + 1), derived(conditions.matrix.rows(), count + 1);
  for (Eigen::Index j = 0; j < dual.unknowns; ++j) {
    const auto unknown = static_cast<std::size_t>(j);
    for (Eigen::Index c = 0; c < count; ++c)
      own(j, c) = height_of(conditions.samples[static_cast<std::size_t>(c)], linkage, dual, unknown, x);
    own(j, count) = height_at(dual.fixed_masses.scale, dual.fixed_masses.coefficients, unknown, x);
  }
  derived << conditions.matrix, -conditions.right;
  const MatrixX a = row_basis(own), b = row_basis(derived);
  if (a.rows() != b.rows()) return false;
  return a.rows() == 0 || (a - (a * b.transpose()) * b).norm() <= row_tolerance;
}

}  // namespace

std::optional<double> compute_min_mass(const DesignSpace& space, const PlanarLinkage& linkage, const VectorX& x) {
  const std::optional<SampleConditions> conditions =
      derive_sample_conditions(space, linkage, x, list_samples(space, linkage));
  return conditions ? find_min_mass(*conditions, linkage, x) : std::nullopt;
}

std::string find_disagreement(const DesignSpace& space, const PlanarLinkage& linkage, const VirtualLinkage& dual,
                              const BoxProgram& program, const LengthBox& box) {
  double largest_mass = 0;
  for (const FreeCounterweight& counterweight : linkage.counterweights) largest_mass += counterweight.upper;
  std::mt19937_64 random(1);
  std::vector<MassLimits> limits = list_mass_limits(linkage);
  const std::vector<int> ratios = list_free_ratios(linkage);
  std::vector<int> numbers = program.lengths();
  numbers.insert(numbers.end(), ratios.begin(), ratios.end());
  int compared = 0;
  for (int trial = 0; trial < max_trials && compared < compared_lengths; ++trial) {
    VectorX x = space.start_values();
    for (const int number : numbers) {
      const double part = static_cast<double>(random() >> 11) * 0x1p-53;
      // the last trials stay near the start, which is more likely to be assembled
      const double near = trial < max_trials / 2 ? 1 : 0.1;
      x[number] += near * (box.lower[number] + part * (box.upper[number] - box.lower[number]) - x[number]);
    }
    LengthBox point = program.point_box(x, box);
    for (const int ratio : ratios) point.lower[ratio] = point.upper[ratio] = x[ratio];
    const BoxBound bound = program.bound(point, {}, limits);
    std::vector<Sample> samples = list_samples(space, linkage);
    for (std::size_t i = 0; i < bound.places.size(); ++i)
      for (const Vector3& place : bound.places[i]) samples.push_back({i, 0, {place[0], place[1], 0}});
    std::optional<SampleConditions> conditions;
    std::optional<double> own;
    try {
      conditions = derive_sample_conditions(space, linkage, x, std::move(samples));
      if (conditions) own = find_min_mass(*conditions, linkage, x);
    } catch (const SpecError&) {
    }
    if (!own) continue;
    ++compared;
    const double fixed = linkage.fixed_size.evaluate(x).real();
    const double scale = 1 + std::abs(*own);
    const double lowest = *own - (linkage.balances_moments ? moment_agreement_tolerance : agreement_tolerance) * scale;
    const bool agrees = std::isinf(*own) ? bound.bound > fixed + largest_mass
                                         : bound.bound <= *own + agreement_tolerance * scale && bound.bound >= lowest;
    if (!agrees || !has_same_rows(*conditions, linkage, dual, x))
      return "its conditions at random lengths are not those of its closures";
  }
  return compared == compared_lengths ? std::string()
                                      : "it could not be assembled with other lengths, for a comparison";
}

}  // namespace balance::certificate
