#include "balance/timing/kept_momentum.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/dynamics/recursion.hpp"
#include "balance/motion/course.hpp"
#include "balance/motion/plan.hpp"
#include "balance/timing/path_source.hpp"
#include "balance/timing/stated_momentum.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace balance {
namespace {

constexpr int terms = PiecewiseSeries::terms;
constexpr int most_even_panels = 8;   // of the whole parameter
constexpr double least_panel = 1e-7;  // of the parameter: where shorter ones would be needed the rate has no bound
constexpr double least_bend = 1e-5;   // in shorter ones series need not end: a third derivative of the path jumps there
constexpr double tolerance = 2e-14;   // of a panel's last terms, as a part of all
constexpr double least_moment =
    1e-10;  // of all masses' moment of inertia at the characteristic length: below it is round-off
constexpr double same_station = 1e-9;  // of the parameter
constexpr int most_iterations = 40;    // of one panel

/// The motion, or its path at constant speed, where the quantities sought stay at their start.
Trajectory standing(const Trajectory& stated, bool over_time) {
  Trajectory trajectory = over_time ? stated : at_constant_speed(stated);
  const PiecewiseSeries nothing({Panel{0, 1, Samples::Zero(terms, 3)}});
  for (Course& course : trajectory.courses)
    if (auto* kept = std::get_if<KeptMomentum>(&course.kind)) kept->course = nothing;
  return trajectory;
}

/// The function whose derivative has these terms on a panel, zero at its beginning.
Samples integral(double begin, double end, const Samples& terms_of) {
  return PiecewiseSeries({Panel{begin, end, terms_of}}).integral().panels().front().terms;
}

template <class S>
class MomentumKeeper {
 public:
  MomentumKeeper(const Mechanism& mechanism, const Trajectory& trajectory)
      : mechanism_(mechanism),
        stated_(mechanism.space, trajectory),
        trajectory_(standing(trajectory, stated_.over_time())),
        duration_(trajectory_.duration),
        tree_(compile<S>(mechanism, prescribed_coordinates(trajectory_))),
        plan_(make_plan(mechanism, tree_, trajectory_)),
        system_(tree_, plan_.drive),
        scale_(column_scale(tree_)),
        state_(tree_.nodes.size()),
        wrenches_(tree_.nodes.size()),
        tau_(static_cast<std::size_t>(tree_.columns)) {}

  MotionOutcome run(Trajectory& trajectory) {
    if (plan_.outcome.status != MotionStatus::done) return plan_.outcome;
    if (const std::string gap = stated_.gap(duration_); stated_.over_time() && !gap.empty())
      return {MotionStatus::mismatch, 0, gap, {}};
    list_components();
    y_ = plan_.start;
    value_ = VectorX::Zero(count());
    if (!find_rates(0, Side::after, value_, rate_)) return stopped(0);
    sign_ = determinant_;
    double begin = 0;
    for (const double end : stations()) {
      const int pieces = std::max(1, static_cast<int>(std::ceil(most_even_panels * (end - begin) - 1e-9)));
      for (int k = 1; k <= pieces; ++k)
        if (!reach(k == pieces ? end : begin + (end - begin) * k / pieces)) return stopped(panels_.back().end);
      begin = end;
    }
    hand_over(trajectory);
    return {MotionStatus::done, 0, "", {}};
  }

 private:
  Eigen::Index count() const { return static_cast<Eigen::Index>(components_.size()); }

  void list_components() {
    Schedule::Request request;
    request.from.value.setZero(plan_.drive.values());
    Trajectory kept = trajectory_;
    std::erase_if(kept.courses, [](const Course& c) { return !std::holds_alternative<KeptMomentum>(c.kind); });
    add_courses(kept, plan_.quantities, request);
    for (const AddedCourse& course : request.courses) components_.push_back(course.component);
    panels_.push_back({0, 0, {}});
  }

  /// Where accelerations or their derivatives jump, and the end, as parts of the parameter.
  std::vector<double> stations() const {
    std::vector<double> times = plan_.schedule->leg_ends();
    for (const auto& more : {plan_.schedule->jumps(), plan_.schedule->knots()})
      times.insert(times.end(), more.begin(), more.end());
    if (stated_.over_time())
      for (const double knot : stated_.knots()) times.push_back(knot);
    std::sort(times.begin(), times.end());
    std::vector<double> ends;
    for (const double time : times)
      if (const double place = time / duration_;
          place - (ends.empty() ? 0 : ends.back()) > same_station && place < 1 - same_station)
        ends.push_back(place);
    ends.push_back(1);
    return ends;
  }

  /// Angular momentum about the trajectory's point for coordinate rates v at the present poses: what would give the resting tree these
  /// rates as accelerations.
  VectorX momentum(const VectorX& v) {
    const VectorX rest = VectorX::Zero(tree_.columns);
    angular_velocities(tree_, rest.data(), state_);
    accelerations<S>(tree_, rest.data(), v.data(), S::Vector::Zero(), state_);
    std::fill(wrenches_.begin(), wrenches_.end(), Wrench<S>());
    inverse_dynamics(tree_, state_, wrenches_, tau_.data());
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    const Vector3 h = angular_to_3d(typename S::Angular(wrenches_[0].moment - cross(about, wrenches_[0].force)));
    return h(stated_.axes());
  }

  /// What the scaled rows ask for: nothing of the closures, the prescribed rates of the others.
  VectorX right_side(const DriveSample& sample) const {
    VectorX rows = VectorX::Zero(system_.rows());
    const auto lengths = static_cast<Eigen::Index>(plan_.drive.point.size() + plan_.drive.com.size());
    Eigen::Index row = system_.closure_rows();
    for (Eigen::Index k = 0; k < sample.rate.size(); ++k, ++row) {
      const bool length = k < lengths || plan_.drive.linear[static_cast<std::size_t>(k - lengths)].is_length;
      rows[row] = sample.rate[k] / (length ? tree_.length : 1);
    }
    for (const int component : plan_.drive.rotation) rows[row++] = sample.angular_velocity[component];
    return rows;
  }

  /// φ' at a place of the parameter where the quantities are φ beyond their start. @return false if there is none
  bool find_rates(double place, Side side, const VectorX& phi, VectorX& rate) {
    DriveSample sample;
    plan_.schedule->at(place * duration_, side, sample);
    for (Eigen::Index i = 0; i < count(); ++i) sample.value[components_[static_cast<std::size_t>(i)]] += phi[i];
    const Solution here = solve(system_, y_, sample);
    if (!here.found || !here.y.allFinite()) return false;
    y_ = here.y;
    VectorX residual;
    MatrixX jacobian;
    system_.evaluate(y_, sample, residual, jacobian);
    const CompleteOrthogonalDecomposition solver(jacobian);
    state_ = system_.state();
    const VectorX others = momentum(scale_.cwiseProduct(solver.solve(right_side(sample))));
    MatrixX J(count(), count());
    for (Eigen::Index i = 0; i < count(); ++i) {
      sample.rate.setZero();
      sample.angular_velocity.setZero();
      sample.rate[components_[static_cast<std::size_t>(i)]] = 1;
      J.col(i) = momentum(scale_.cwiseProduct(solver.solve(right_side(sample))));
    }
    determinant_ = J.determinant();
    rate = duration_ * J.fullPivLu().solve(stated_.at(place * duration_) - others);
    const double least = least_moment * tree_.mass * tree_.length * tree_.length;
    return J.allFinite() && min_coefficient(singular_values(J)) > least && rate.allFinite() &&
           determinant_ * sign_ >= 0;
  }

  /// Extends the courses to a place, in as many panels as it takes.
  bool reach(double end) {
    double next = end;
    while (panels_.back().end < end) {
      const double begin = panels_.back().end;
      if (add_panel(begin, next)) {
        next = end;
        continue;
      }
      next = begin + (next - begin) / 2;
      if (next - begin < least_panel) return false;
    }
    return true;
  }

  /// Picard's iteration on the values at the points.
  bool add_panel(double begin, double end) {
    const VectorX y = y_;
    Samples rates = rate_.transpose().replicate(terms, 1), previous;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      previous = rates;
      y_ = y;
      const Samples values = values_at_points(integral(begin, end, PiecewiseSeries::transform() * rates));
      for (int k = 0; k < terms; ++k) {
        const double place = (begin + end) / 2 + (end - begin) / 2 * PiecewiseSeries::point(k);
        if (!find_rates(place, Side::after, value_ + values.row(k).transpose(), rate_found_)) return give_up(y);
        rates.row(k) = rate_found_.transpose();
      }
      const double change = max_abs(rates - previous), size = max_abs(rates);
      if (!(change < 1e6 * (1 + size))) return give_up(y);
      if (change <= 1e-14 * size || (iteration > 4 && change <= 1e-12 * size)) return finish(begin, end, rates, y);
    }
    return give_up(y);
  }

  static Samples values_at_points(const Samples& series) {
    const PiecewiseSeries function({Panel{-1, 1, series}});
    Samples values(terms, series.cols());
    for (int k = 0; k < terms; ++k) function.at(0, PiecewiseSeries::point(k), &values(k, 0));
    return values;
  }

  bool give_up(const VectorX& y) {
    y_ = y;
    return false;
  }

  bool finish(double begin, double end, const Samples& rates, const VectorX& y) {
    const Samples rate = PiecewiseSeries::transform() * rates;
    for (Eigen::Index c = 0; c < rate.cols() && end - begin > least_bend; ++c)
      if (max_abs(rate.col(c).tail(3)) > tolerance * rate.col(c).cwiseAbs().sum() + 1e-15) return give_up(y);
    Samples value = integral(begin, end, rate);
    value.row(0) += value_.transpose();
    panels_.push_back({begin, end, value});
    rates_.push_back({begin, end, rate});
    VectorX there(count());
    PiecewiseSeries({panels_.back()}).at(0, end, there.data());
    value_ = there;
    if (!find_rates(end, Side::before, value_, rate_)) return give_up(y);
    return true;
  }

  /// Value, rate and its derivative of each quantity, from the rate: what it was integrated from is kept to the last digit.
  void hand_over(Trajectory& trajectory) const {
    const PiecewiseSeries second = PiecewiseSeries(rates_).derivative();
    Eigen::Index found = 0;
    for (Course& course : trajectory.courses) {
      auto* kept = std::get_if<KeptMomentum>(&course.kind);
      if (kept == nullptr) continue;
      std::vector<Panel> panels;
      for (std::size_t p = 0; p < rates_.size(); ++p) {
        Panel panel{rates_[p].begin, rates_[p].end, Samples(terms, 3)};
        panel.terms << panels_[p + 1].terms.col(found), rates_[p].terms.col(found), second.panels()[p].terms.col(found);
        panels.push_back(std::move(panel));
      }
      kept->course = PiecewiseSeries(std::move(panels));
      kept->over_time = stated_.over_time();
      ++found;
    }
  }

  MotionOutcome stopped(double place) const {
    const double way = 100 * plan_.schedule->way(place * duration_, Side::after).s;
    char where[96], text[320];
    if (stated_.over_time())
      std::snprintf(where, sizeof where, "at t = %.6g s, %.4g %% of the path,", place * duration_, way);
    else
      std::snprintf(where, sizeof where, "at %.4g %% of the path", way);
    std::snprintf(
        text, sizeof text,
        "%s the angular momentum can no longer be kept at %s: what the remaining rate%s to it loses its %s there "
        "(%.6g %s at the start)",
        where, stated_.over_time() ? "what is stated" : "zero", count() == 1 ? " adds" : "s add",
        count() == 1 ? "sign" : "rank", sign_, unit());
    return {MotionStatus::drive_singularity, stated_.over_time() ? place * duration_ : 0, text, {}};
  }

  /// Of the determinant of J where all rates are those of angles.
  const char* unit() const { return count() == 1 ? "kg m^2" : count() == 2 ? "kg^2 m^4" : "kg^3 m^6"; }

  const Mechanism& mechanism_;
  StatedMomentum stated_;
  Trajectory trajectory_;
  double duration_;  ///< of the trajectory followed: 1 where the parameter is the way [s]
  Tree<S> tree_;
  Plan<S> plan_;
  System<S> system_;
  VectorX scale_;
  State<S> state_;
  std::vector<Wrench<S>> wrenches_;
  std::vector<double> tau_;
  std::vector<Eigen::Index> components_;  ///< of the drive's values
  VectorX y_, value_, rate_, rate_found_;
  double determinant_ = 0;
  double sign_ = 0;            ///< determinant of J at the start
  std::vector<Panel> panels_;  ///< values; the first one is empty and ends at 0
  std::vector<Panel> rates_;
};

}  // namespace

MotionOutcome keep_momentum(const Mechanism& mechanism, Trajectory& trajectory) {
  const auto unknown = [](const Course& course) {
    const auto* kept = std::get_if<KeptMomentum>(&course.kind);
    return kept != nullptr && kept->course.panels().empty();
  };
  if (std::none_of(trajectory.courses.begin(), trajectory.courses.end(), unknown))
    return {MotionStatus::done, 0, "", {}};
  return in_space(mechanism.space,
                  [&]<class S>(S) { return MomentumKeeper<S>(mechanism, trajectory).run(trajectory); });
}

}  // namespace balance
