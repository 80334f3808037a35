#include "balance/synthesis/conditions/chosen_speeds.hpp"

#include <algorithm>

namespace balance::conditions {

namespace {

template <class Predicate>
bool any_term(const std::vector<model::GeneralisedSpeed>& speeds, const Predicate& predicate) {
  return std::any_of(speeds.begin(), speeds.end(), [&](const model::GeneralisedSpeed& speed) {
    return std::any_of(speed.terms.begin(), speed.terms.end(), predicate);
  });
}

int find_point(const Mechanism& mechanism, const model::GeneralisedSpeedTerm& term) {
  const std::vector<model::NamedPoint>& points = mechanism.bodies[static_cast<std::size_t>(term.body)].points;
  const auto at = std::find_if(points.begin(), points.end(),
                               [&](const model::NamedPoint& point) { return point.position == term.position; });
  return at == points.end() || term.position.isZero(0) ? -1 : static_cast<int>(at - points.begin());
}

}  // namespace

ChosenSpeeds::ChosenSpeeds(const Mechanism& mechanism, std::vector<model::GeneralisedSpeed> speeds)
    : speeds_(std::move(speeds)) {
  for (const model::GeneralisedSpeed& speed : speeds_) {
    points_.emplace_back();
    for (const model::GeneralisedSpeedTerm& term : speed.terms) points_.back().push_back(find_point(mechanism, term));
  }
}

std::vector<model::GeneralisedSpeed> ChosenSpeeds::in(const Mechanism& mechanism) const {
  std::vector<model::GeneralisedSpeed> speeds = speeds_;
  for (std::size_t i = 0; i < speeds.size(); ++i)
    for (std::size_t k = 0; k < speeds[i].terms.size(); ++k) {
      model::GeneralisedSpeedTerm& term = speeds[i].terms[k];
      if (points_[i][k] < 0) continue;
      term.position = mechanism.bodies[static_cast<std::size_t>(term.body)]
                          .points[static_cast<std::size_t>(points_[i][k])]
                          .position;
    }
  return speeds;
}

ChosenSpeeds ChosenSpeeds::repeat(const Mechanism& mechanism, int copies) const {
  ChosenSpeeds all;
  const int bodies = static_cast<int>(mechanism.bodies.size()) - 1,
            coordinates = static_cast<int>(mechanism.coordinates.size());
  for (int copy = 0; copy < copies; ++copy)
    for (std::size_t i = 0; i < speeds_.size(); ++i) {
      model::GeneralisedSpeed speed = speeds_[i];
      for (model::GeneralisedSpeedTerm& term : speed.terms) {
        if (term.body != model::ground) term.body += copy * bodies;
        if (term.kind == model::GeneralisedSpeedTerm::Kind::coordinate) term.index += copy * coordinates;
        for (CoordinateId& variable : term.pose_variables) variable += copy * coordinates;
      }
      all.speeds_.push_back(std::move(speed));
      all.points_.push_back(points_[i]);
    }
  return all;
}

std::vector<CoordinateId> ChosenSpeeds::coordinates() const {
  std::vector<CoordinateId> coordinates;
  for (const model::GeneralisedSpeed& speed : speeds_)
    for (const model::GeneralisedSpeedTerm& term : speed.terms) {
      if (term.kind == model::GeneralisedSpeedTerm::Kind::coordinate) coordinates.emplace_back(term.index);
      coordinates.insert(coordinates.end(), term.pose_variables.begin(), term.pose_variables.end());
    }
  return coordinates;
}

bool ChosenSpeeds::depend_on_masses() const {
  return any_term(speeds_, [](const model::GeneralisedSpeedTerm& term) {
    return term.kind == model::GeneralisedSpeedTerm::Kind::com_velocity;
  });
}

bool ChosenSpeeds::has_parameters() const {
  return any_term(speeds_,
                  [](const model::GeneralisedSpeedTerm& term) { return !term.pose_factor.parameters.empty(); });
}

}  // namespace balance::conditions
