#include "balance/timing/stated_momentum.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace balance {
namespace {

constexpr double end_time_tolerance = 1e-9;  // of the duration: times nearer than this are one

/// Few values are joined by the spline that they are enough for.
SplineEnd choose_spline_end(std::size_t values) { return values < 4 ? SplineEnd::natural : SplineEnd::not_a_knot; }

}  // namespace

PrescribedMomentum::PrescribedMomentum(SpaceKind space, const Trajectory& trajectory) {
  bool splines = false;
  for (const SecondaryTask& course : trajectory.secondary_tasks)
    if (const auto* kept = std::get_if<MomentumTask>(&course.kind))
      add(*kept);
    else
      splines = splines || std::get<SplineTask>(course.kind).over_time;
  check(space);
  over_time_ = over_time_ || splines;
  if (over_time_ && is_mechanism_dependent(trajectory.law.kind))
    throw std::invalid_argument(
        "beside a law that is searched for the angular momentum can be kept at zero alone: otherwise it is the law "
        "that decides "
        "when it has which value");
}

void PrescribedMomentum::add(const MomentumTask& kept) {
  axes_.push_back(kept.axis);
  const bool zero = std::all_of(kept.value.begin(), kept.value.end(), [](double value) { return value == 0; });
  over_time_ = over_time_ || !zero;
  Component component;
  if (kept.time.empty()) {
    component.constant = kept.value.empty() ? 0 : kept.value.front();
  } else {
    const Samples values = Eigen::Map<const VectorX>(kept.value.data(), static_cast<Eigen::Index>(kept.value.size()));
    component.spline.emplace(kept.time, values, choose_spline_end(kept.time.size()));
  }
  components_.push_back(std::move(component));
}

void PrescribedMomentum::check(SpaceKind space) const {
  if (space == SpaceKind::planar && axes_.size() != 1)
    throw std::invalid_argument(
        "one quantity keeps the angular momentum of a planar mechanism, which has one component");
  std::vector<int> sorted = axes_;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw std::invalid_argument("every quantity that keeps the angular momentum takes care of a component of its own");
}

VectorX PrescribedMomentum::at(double time) const {
  VectorX all(static_cast<Eigen::Index>(components_.size())), value(1), first(1), second(1);
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Component& component = components_[i];
    if (component.spline) component.spline->at(time, value, first, second);
    all[static_cast<Eigen::Index>(i)] = component.spline ? value[0] : component.constant;
  }
  return all;
}

std::vector<double> PrescribedMomentum::knots() const {
  std::vector<double> all;
  for (const Component& component : components_)
    if (component.spline) all.insert(all.end(), component.spline->knots().begin(), component.spline->knots().end());
  return all;
}

std::string PrescribedMomentum::uncovered_interval(double duration) const {
  for (const Component& component : components_) {
    if (!component.spline) continue;
    const double first = component.spline->knots().front(), last = component.spline->knots().back();
    if (first <= end_time_tolerance * duration && last >= (1 - end_time_tolerance) * duration) continue;
    char text[160];
    std::snprintf(text, sizeof text,
                  "the angular momentum is stated from %.6g s to %.6g s, but the motion lasts from 0 to %.6g s", first,
                  last, duration);
    return text;
  }
  return "";
}

}  // namespace balance
