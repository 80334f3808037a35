#include "balance/synthesis/certificate/figure_box.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::certificate {
namespace {

/// Relative to the terms of the bound: the rounding of its last sums, which are not intervals.
constexpr double figure_sum_margin = 1e-13;
/// Relative to the bound: figures of the program are computed in floating point, too.
constexpr double figure_round_off = 1e-9;
/// Relative to the largest weight: moments with less weight are left out.
constexpr double negligible_weight = 1e-10;
/// The corners of a box in t = (length − middle) / half width, with its rounding.
constexpr double corner_margin = 1e-12;
/// Relative: a narrower box is a point.
constexpr double min_relative_radius = 1e-13;

/// Weights that are affine on the box: constant + Σ slope_k t_k, t from −1 to 1.
struct AffineWeights {
  VectorX constant;
  std::vector<VectorX> slopes;

  /// Least squares over the corners that are known; without slopes their mean.
  void fit(const std::vector<const VectorX*>& corners, std::size_t lengths, bool has_slopes) {
    double count = 0;
    for (const VectorX* corner : corners)
      if (corner) {
        if (count == 0) constant.setZero(corner->size());
        constant += *corner;
        ++count;
      }
    constant /= count;
    slopes.assign(lengths, VectorX::Zero(constant.size()));
    if (!has_slopes || count < static_cast<double>(corners.size())) return;
    for (std::size_t c = 0; c < corners.size(); ++c)
      for (std::size_t k = 0; k < lengths; ++k) slopes[k] += (c >> k & 1U ? 1 : -1) * *corners[c] / count;
  }

  void clear(Eigen::Index first, Eigen::Index count) {
    constant.segment(first, count).setZero();
    for (VectorX& slope : slopes) slope.segment(first, count).setZero();
  }

  bool is_negligible(Eigen::Index first, Eigen::Index count, double threshold) const {
    double size = numerics::max_abs(constant.segment(first, count));
    for (const VectorX& slope : slopes) size += numerics::max_abs(slope.segment(first, count));
    return size <= threshold;
  }

  double max_size() const {
    double size = numerics::max_abs(constant);
    for (const VectorX& slope : slopes) size = std::max(size, numerics::max_abs(slope));
    return size;
  }

  VectorX at_corner(std::size_t corner) const {
    VectorX value = constant;
    for (std::size_t k = 0; k < slopes.size(); ++k) value += (corner >> k & 1U ? 1 : -1) * slopes[k];
    return value;
  }

  /// @param t per length
  IntervalJet evaluate(Eigen::Index i, const std::vector<IntervalJet>& t) const {
    IntervalJet sum = constant[i];
    for (std::size_t k = 0; k < slopes.size(); ++k)
      if (slopes[k][i] != 0) sum += slopes[k][i] * t[k];
    return sum;
  }
};

/// A force and its weights in each series.
struct WeightedForce {
  MotionForce force;
  double factor = 1;
  bool is_peak = false, is_vanishing = false;
  Eigen::Index components = 1;
  std::vector<AffineWeights> series;
};

/// A function of the lengths on the box: value and gradient in the middle, second-order remainder.
struct TaylorForm {
  Interval value;
  std::vector<Interval> gradient;
  double below = 0, above = 0;  ///< non-negative
  VectorX losses;               ///< of the remainder, per length

  /// @param middle of order 1 @param box of order 2 @param radii half widths, rounded up
  TaylorForm(const IntervalJet& middle, const IntervalJet& box, const VectorX& radii) : value(middle.value) {
    const auto n = static_cast<int>(radii.size());
    losses.setZero(n);
    Interval low, high;
    for (int i = 0; i < n; ++i) {
      gradient.push_back(middle.derivative(i));
      const Interval own = box.second_derivative(i, i), square = Interval(radii[i]) * radii[i] * 0.5;
      low += Interval(std::min(0.0, own.lower)) * square;
      high += Interval(std::max(0.0, own.upper)) * square;
      losses[i] += own.magnitude() * square.upper;
      for (int j = 0; j < i; ++j) {
        const Interval cross = Interval(box.second_derivative(i, j).magnitude()) * radii[i] * radii[j];
        low -= cross;
        high += cross;
        losses[i] += 0.5 * cross.upper;
        losses[j] += 0.5 * cross.upper;
      }
    }
    below = -low.lower;
    above = high.upper;
  }

  /// Bounds at a corner of the box, where linear functions have their extrema.
  Interval at_corner(std::size_t corner, const VectorX& radii) const {
    Interval sum = value;
    for (std::size_t k = 0; k < gradient.size(); ++k)
      sum += gradient[k] * (corner >> k & 1U ? 1 : -1) * Interval(radii[static_cast<Eigen::Index>(k)]);
    return {(Interval(sum.lower) - below).lower, (Interval(sum.upper) + above).upper};
  }
};

/// Least a x + b x² for low ≤ x ≤ high, for the worst a and b of their intervals.
double min_place_term(const Interval& a, const Interval& b, double low, double high, double& place) {
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double x) {
    const double value = std::min(a.lower * x, a.upper * x) + b.lower * x * x;
    if (value < least) least = value, place = x;
  };
  consider(low);
  consider(high);
  if (low < 0 && high > 0) consider(0);
  if (b.lower > 0)
    for (const double slope : {a.lower, a.upper})
      if (const double x = -slope / (2 * b.lower); low < x && x < high) consider(x);
  return least;
}

/// What an element contributes: mass · (base + Σ linear x + square x²), and inertia · rotation.
struct ElementForms {
  TaylorForm base, rotation;
  std::array<std::optional<TaylorForm>, 2> linear;
  std::optional<TaylorForm> square;
};

class FigureBox {
 public:
  FigureBox(const DesignSpace& space, const FigureProblem& problem, const LengthBox& box, const SampledMotion& middle,
            const std::vector<const FigureDual*>& corners, const VectorX& time_weights)
      : space_(space), problem_(problem), box_(box), motion_(middle), time_weights_(time_weights) {
    result_.losses.setZero(static_cast<Eigen::Index>(problem.lengths.size()));
    fit_weights(corners, true);
    // weights of peaks jump from one set of moments to another, and no affine function follows them there
    if (std::any_of(problem.figures.begin(), problem.figures.end(), [](const ForceFigure& f) { return f.is_peak; }))
      fit_weights(corners, false);
  }

  FigureBoxBound bound() {
    set_radii();
    const LoadedLinkage point = enclose_linkage(space_, problem_, middle_, 0),
                        slope = enclose_linkage(space_, problem_, middle_, 1),
                        values = enclose_linkage(space_, problem_, box_, 0),
                        slopes = enclose_linkage(space_, problem_, box_, 1),
                        curvatures = enclose_linkage(space_, problem_, box_, 2);
    const std::vector<Interval> none(problem_.lengths.size(), Interval());
    const BoxLinkages at_middle{point.linkage, point.linkage, slope.linkage, slope.linkage, none, 1};
    const BoxLinkages on_box{point.linkage, values.linkage, slopes.linkage, curvatures.linkage, steps_, 2};
    MotionEnclosure middle(at_middle, problem_.drive), box(on_box, problem_.drive);
    std::vector<ForceFunctional> of_middle(candidates_.size(), ForceFunctional(problem_, slope)),
        of_box(candidates_.size(), ForceFunctional(problem_, curvatures));
    const std::vector<IntervalJet> t_middle = box_coordinates(1), t_box = box_coordinates(2);
    for (std::size_t s = 0; s < static_cast<std::size_t>(time_weights_.size()); ++s) {
      if (!has_weight(s)) continue;
      const bool is_enclosed =
          s < motion_.points.size() && middle.enclose(motion_.points[s]) && box.enclose(motion_.points[s]);
      if (is_enclosed) ++result_.enclosed;
      for (std::size_t c = 0; c < candidates_.size(); ++c)
        if (!is_enclosed || !add_moment(s, candidates_[c], middle, t_middle, box, t_box, of_middle[c], of_box[c]))
          drop(s, candidates_[c]);
    }
    for (std::size_t c = 0; c < candidates_.size(); ++c)
      combine(candidates_[c], slope, curvatures, of_middle[c], of_box[c]);
    return std::move(result_);
  }

 private:
  using Weights = std::vector<WeightedForce>;

  void fit_weights(const std::vector<const FigureDual*>& corners, bool has_slopes) {
    Weights& forces = candidates_.emplace_back();
    const std::size_t actuators = space_.start.mechanism.actuators.size();
    const auto add = [&](const MotionForce& force, double factor, bool is_peak, bool is_vanishing,
                         auto multipliers_of) {
      WeightedForce weighted{force, factor, is_peak, is_vanishing, force.components(actuators), {}};
      for (int s = 0; s < force.series(actuators); ++s) {
        std::vector<const VectorX*> known;
        for (const FigureDual* corner : corners)
          known.push_back(corner ? &multipliers_of(*corner)[static_cast<std::size_t>(s)] : nullptr);
        weighted.series.emplace_back().fit(known, problem_.lengths.size(), has_slopes);
      }
      forces.push_back(std::move(weighted));
    };
    for (std::size_t f = 0; f < problem_.figures.size(); ++f)
      add(problem_.figures[f].force, problem_.figures[f].weight, problem_.figures[f].is_peak, false,
          [f](const FigureDual& dual) -> const ForceMultipliers& { return dual.figures[f]; });
    for (std::size_t f = 0; f < problem_.vanishing.size(); ++f)
      add(problem_.vanishing[f], 1, false, true,
          [f](const FigureDual& dual) -> const ForceMultipliers& { return dual.vanishing[f]; });
    for (WeightedForce& force : forces)
      for (AffineWeights& series : force.series) {
        const double threshold = negligible_weight * series.max_size();
        for (Eigen::Index s = 0; s < time_weights_.size(); ++s)
          if (series.is_negligible(s * force.components, force.components, threshold))
            series.clear(s * force.components, force.components);
      }
  }

  bool has_weight(std::size_t s) const {
    const auto sample = static_cast<Eigen::Index>(s);
    for (const Weights& forces : candidates_)
      for (const WeightedForce& force : forces)
        for (const AffineWeights& series : force.series)
          if (!series.is_negligible(sample * force.components, force.components, 0)) return true;
    return false;
  }

  /// Adds a moment of the motion to the functionals of the middle and of the box, or to neither.
  bool add_moment(std::size_t s, const Weights& forces, MotionEnclosure& middle,
                  const std::vector<IntervalJet>& t_middle, MotionEnclosure& box, const std::vector<IntervalJet>& t_box,
                  ForceFunctional& of_middle, ForceFunctional& of_box) const {
    try {
      ForceFunctional next_middle = of_middle, next_box = of_box;
      next_middle.add(middle, weights_at(s, forces, t_middle));
      next_box.add(box, weights_at(s, forces, t_box));
      of_middle = std::move(next_middle);
      of_box = std::move(next_box);
      return true;
    } catch (const EnclosureError&) {
      return false;
    }
  }

  static void drop(std::size_t s, Weights& forces) {
    for (WeightedForce& force : forces)
      for (AffineWeights& series : force.series)
        series.clear(static_cast<Eigen::Index>(s) * force.components, force.components);
  }

  void set_radii() {
    middle_ = box_;
    const auto count = static_cast<Eigen::Index>(problem_.lengths.size());
    radii_.resize(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const int length = problem_.lengths[static_cast<std::size_t>(k)];
      const double low = box_.lower[length], high = box_.upper[length], middle = low + 0.5 * (high - low);
      middle_.lower[length] = middle_.upper[length] = middle;
      steps_.push_back(Interval(low, high) - middle);
      radii_[k] = steps_.back().magnitude();
    }
  }

  /// t of each length, in the middle (order 1) or on the box.
  std::vector<IntervalJet> box_coordinates(int order) const {
    std::vector<IntervalJet> t;
    const auto count = static_cast<int>(problem_.lengths.size());
    for (int k = 0; k < count; ++k) {
      const Interval step = order == 1 ? Interval() : steps_[static_cast<std::size_t>(k)];
      // on a point the weights are constant
      t.push_back(radii_[k] > min_relative_radius * numerics::max_abs(box_.upper)
                      ? IntervalJet::variable(step, k, count, order) * inverse(Interval(radii_[k]))
                      : IntervalJet(0.0));
    }
    return t;
  }

  ForceWeights weights_at(std::size_t s, const Weights& forces, const std::vector<IntervalJet>& t) const {
    using Kind = MotionForce::Kind;
    ForceWeights weights;
    const std::size_t actuators = space_.start.mechanism.actuators.size();
    const auto sample = static_cast<Eigen::Index>(s);
    for (const WeightedForce& force : forces) {
      const double scale = force.factor * (force.is_peak ? 1 : std::sqrt(time_weights_[sample]));
      const auto weight = [&](std::size_t series, Eigen::Index component) {
        return scale * force.series[series].evaluate(sample * force.components + component, t);
      };
      switch (force.force.kind) {
        case Kind::shaking_force:
          for (int c = 0; c < 2; ++c)
            if (!force.force.component || *force.force.component == c)
              weights.force[static_cast<std::size_t>(c)] += weight(0, force.force.component ? 0 : c);
          break;
        case Kind::shaking_moment: {
          // about P: M − P × F
          const IntervalJet moment = weight(0, 0);
          weights.moment += moment;
          weights.force[0] += force.force.about.y() * moment;
          weights.force[1] -= force.force.about.x() * moment;
          break;
        }
        case Kind::torque:
          weights.torques.resize(actuators, IntervalJet());
          for (std::size_t a = 0; a < actuators; ++a) {
            if (force.force.actuator && *force.force.actuator != static_cast<int>(a)) continue;
            if (force.force.actuator)
              weights.torques[a] += weight(0, 0);
            else if (force.force.is_combined)
              weights.torques[a] += weight(0, static_cast<Eigen::Index>(a));
            else
              weights.torques[a] += weight(a, 0);
          }
          break;
      }
    }
    return weights;
  }

  /// Dual norm of a figure's weights, the largest on the box: norms are convex, so it is at a corner.
  double weight_norm(const WeightedForce& force) const {
    double largest = 0;
    for (std::size_t corner = 0; corner < std::size_t(1) << problem_.lengths.size(); ++corner) {
      double sum = 0;
      for (const AffineWeights& series : force.series) {
        const VectorX weights = series.at_corner(corner);
        if (!force.is_peak) {
          sum += weights.norm();
          continue;
        }
        for (Eigen::Index s = 0; s < time_weights_.size(); ++s)
          sum += weights.segment(s * force.components, force.components).norm();
      }
      largest = std::max(largest, sum);
    }
    return largest * (1 + corner_margin);
  }

  void combine(const Weights& forces, const LoadedLinkage& point, const LoadedLinkage& box,
               const ForceFunctional& of_middle, const ForceFunctional& of_box) {
    double norm = 0;
    for (const WeightedForce& force : forces)
      if (!force.is_vanishing) norm = std::max(norm, weight_norm(force));
    if (!(norm > 0)) return;
    const auto form = [&](const IntervalJet& a, const IntervalJet& b) { return TaylorForm(a, b, radii_); };
    const TaylorForm fixed = form(of_middle.fixed(), of_box.fixed());
    std::vector<ElementForms> elements;
    for (std::size_t e = 0; e < problem_.elements.size(); ++e)
      elements.push_back(make_element(e, point.elements[e], box.elements[e], of_middle, of_box));
    double least = std::numeric_limits<double>::infinity();
    VectorX losses = result_.losses;
    for (std::size_t corner = 0; corner < std::size_t(1) << problem_.lengths.size(); ++corner)
      least = std::min(least, minimise_at(corner, fixed, elements, norm, least, losses));
    const double bound = least / norm - figure_round_off * std::abs(least / norm);
    if (!(bound > result_.bound)) return;
    result_.bound = bound;
    result_.losses = losses;
  }

  ElementForms make_element(std::size_t e, const ElementEnclosure& point, const ElementEnclosure& box,
                            const ForceFunctional& of_middle, const ForceFunctional& of_box) const {
    const FreeElement& element = problem_.elements[e];
    const auto parts = [&](const ElementEnclosure& own, const std::array<IntervalJet, 4>& c) {
      std::array<IntervalJet, 4> sums{c[0], c[1], c[2], c[3]};
      for (std::size_t k = 0; k < 2; ++k)
        if (element.place_numbers[k] < 0) sums[0] += own.place[k] * c[1 + k] + own.place[k] * own.place[k] * c[3];
      if (element.mass_number < 0)
        for (IntervalJet& sum : sums) sum *= own.mass;
      return sums;
    };
    const auto a = parts(point, of_middle.coefficients(e)), b = parts(box, of_box.coefficients(e));
    ElementForms forms{TaylorForm(a[0], b[0], radii_),
                       TaylorForm(of_middle.coefficients(e)[3], of_box.coefficients(e)[3], radii_),
                       {},
                       {}};
    for (std::size_t k = 0; k < 2; ++k)
      if (element.place_numbers[k] >= 0) forms.linear[k].emplace(a[1 + k], b[1 + k], radii_);
    if (forms.linear[0] || forms.linear[1]) forms.square.emplace(a[3], b[3], radii_);
    return forms;
  }

  /// The least value over the masses, the lengths being at a corner of the box for the linear parts: it is a concave
  /// function of them, so that it is least at a corner.
  double minimise_at(std::size_t corner, const TaylorForm& fixed, const std::vector<ElementForms>& elements,
                     double norm, double best, VectorX& losses_at_best) const {
    const double first = fixed.at_corner(corner, radii_).lower;
    double sum = first, magnitude = std::abs(first);
    VectorX losses = fixed.losses;
    VectorX slope = VectorX::Zero(radii_.size());
    for (Eigen::Index k = 0; k < slope.size(); ++k) slope[k] = fixed.gradient[static_cast<std::size_t>(k)].middle();
    const auto note = [&](const TaylorForm& form, double factor) {
      losses += std::abs(factor) * form.losses;
      for (Eigen::Index k = 0; k < slope.size(); ++k)
        slope[k] += factor * form.gradient[static_cast<std::size_t>(k)].middle();
    };
    struct AddedMass {
      double value, room;
      std::size_t element;
    };
    std::vector<AddedMass> added;
    std::vector<std::array<double, 2>> places(elements.size(), {0, 0});
    std::vector<double> masses(elements.size(), 1);
    double room = problem_.max_added_mass.value_or(std::numeric_limits<double>::infinity());
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const FreeElement& own = problem_.elements[e];
      const ElementForms& forms = elements[e];
      double value = forms.base.at_corner(corner, radii_).lower;
      double size = std::abs(value);
      for (std::size_t k = 0; k < 2; ++k) {
        if (!forms.linear[k]) continue;
        const double low = problem_.lower[own.place_numbers[k]], high = problem_.upper[own.place_numbers[k]];
        const double term = min_place_term(forms.linear[k]->at_corner(corner, radii_),
                                           forms.square->at_corner(corner, radii_), low, high, places[e][k]);
        value += term;
        size += std::abs(term);
      }
      value -= 8 * figure_sum_margin * size;
      if (own.mass_number < 0) {
        sum += value;
        magnitude += std::abs(value);
      } else {
        const double low = problem_.lower[own.mass_number], high = problem_.upper[own.mass_number];
        masses[e] = low;
        sum += low * value;
        magnitude += std::abs(low * value);
        if (own.is_added) room -= low;
        if (value < 0 && !own.is_added) {
          masses[e] = high;
          sum += (high - low) * value;
          magnitude += std::abs((high - low) * value);
        } else if (value < 0) {
          added.push_back({value, high - low, e});
        }
      }
      if (own.inertia_number >= 0) {
        const double rotation = forms.rotation.at_corner(corner, radii_).lower;
        const double inertia = rotation < 0 ? problem_.upper[own.inertia_number] : problem_.lower[own.inertia_number];
        sum += inertia * rotation;
        magnitude += std::abs(inertia * rotation);
        note(forms.rotation, inertia);
      }
    }
    std::sort(added.begin(), added.end(), [](const AddedMass& a, const AddedMass& b) { return a.value < b.value; });
    room = std::max(0.0, room * (1 + 1e-9));  // the limit counts as kept up to 1e-9
    for (const AddedMass& one : added) {
      const double mass = std::min(one.room, room);
      masses[one.element] += mass;
      sum += mass * one.value;
      magnitude += std::abs(mass * one.value);
      room -= mass;
    }
    sum -= figure_sum_margin * static_cast<double>(8 + elements.size()) * magnitude;
    if (!(sum >= best)) {
      for (std::size_t e = 0; e < elements.size(); ++e) {
        note(elements[e].base, masses[e]);
        for (std::size_t k = 0; k < 2; ++k)
          if (elements[e].linear[k]) {
            note(*elements[e].linear[k], masses[e] * places[e][k]);
            note(*elements[e].square, masses[e] * places[e][k] * places[e][k]);
          }
      }
      losses_at_best = (losses + slope.cwiseAbs().cwiseProduct(radii_)) / norm;
    }
    return std::isnan(sum) ? -std::numeric_limits<double>::infinity() : sum;
  }

  const DesignSpace& space_;
  const FigureProblem& problem_;
  const LengthBox& box_;
  const SampledMotion& motion_;
  const VectorX& time_weights_;
  LengthBox middle_;
  std::vector<Interval> steps_;
  VectorX radii_;
  std::vector<Weights> candidates_;
  FigureBoxBound result_;
};

}  // namespace

SampledMotion sample_planar_motion(const DesignSpace& space, const FigureProblem& problem, const VectorX& x) {
  SampledMotion result;
  const study::DesignInstance instance = space.instantiate(x);
  if (!instance.mode_issue.empty() || instance.is_other_mode) return result;
  const Trajectory& trajectory = instance.trajectories[static_cast<std::size_t>(problem.trajectory)];
  try {
    const kinematics::CompiledMotion<kinematics::Planar> motion(instance.mechanism, trajectory);
    dynamics::TreeMotionSource<kinematics::Planar> source(instance.mechanism, motion, trajectory.about,
                                                          dynamics::Detail::kinematics);
    if (source.outcome().status != MotionStatus::done) return result;
    using Kind = trajectory::TimeGridPoint::Kind;
    result.is_complete = visit_time_grid(source, trajectory.samples, [&](const trajectory::TimeGridPoint& point) {
      if (point.kind == Kind::after_jump && point.has_coincident_next) return true;
      trajectory::DriveSample target;
      const auto side = point.kind == Kind::before_jump ? trajectory::Side::before : trajectory::Side::after;
      source.prescribed_motion().at(source.time(), side, target);
      MotionPoint& one = result.points.emplace_back();
      one.y = Eigen::Map<const VectorX>(source.stepper().y(), motion.tree.columns);
      one.value = target.value;
      one.rate = target.rate;
      one.acceleration = target.acceleration;
      return true;
    });
  } catch (const std::invalid_argument&) {
  }
  return result;
}

FigureBoxBound bound_figures(const DesignSpace& space, const FigureProblem& problem, const LengthBox& box,
                             const SampledMotion& middle, const std::vector<const FigureDual*>& corners,
                             const VectorX& time_weights) {
  try {
    return FigureBox(space, problem, box, middle, corners, time_weights).bound();
  } catch (const EnclosureError&) {
    return {};
  }
}

}  // namespace balance::certificate
