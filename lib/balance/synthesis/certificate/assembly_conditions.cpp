#include "balance/synthesis/certificate/assembly_conditions.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::certificate {
namespace {

/// Poses between the ends of the motion of a single joint.
constexpr int pose_intervals = 8;
/// Relative to the terms of a condition: what the library's assembly may accept beyond it, with a margin.
constexpr double reach_tolerance = 1e-9;
constexpr int max_contractions = 4;
/// Relative to the box: smaller contractions are not repeated.
constexpr double min_contraction = 0.05;

/// What a trajectory prescribes at one moment.
struct PrescribedPose {
  std::map<int, double> joints;  ///< coordinate → value
  std::optional<Vector3> tool;
};

std::vector<PrescribedPose> list_poses(const TrajectoryOf<Expression>& trajectory) {
  std::vector<PrescribedPose> poses;
  const auto add = [&](const trajectory::PoseTargetOf<Expression>& target) {
    PrescribedPose pose;
    if (trajectory.drive == DriveKind::joints)
      for (const auto& joint : target.joints)
        if (joint.value.is_constant()) pose.joints[joint.coordinate] = joint.value.value();
    if (trajectory.drive == DriveKind::tool && target.tool && (*target.tool)[0].is_constant() &&
        (*target.tool)[1].is_constant())
      pose.tool = Vector3((*target.tool)[0].value(), (*target.tool)[1].value(), 0);
    poses.push_back(std::move(pose));
  };
  if (trajectory.corridor || std::holds_alternative<trajectory::TablePathOf<Expression>>(trajectory.path)) return poses;
  add(trajectory.from);
  if (const auto* waypoints = std::get_if<trajectory::WaypointPathOf<Expression>>(&trajectory.path))
    for (const auto& point : waypoints->points) add(point);
  if (!std::holds_alternative<trajectory::CirclePathOf<Expression>>(trajectory.path)) add(trajectory.to);
  if (poses.size() != 2 || poses[0].joints.size() != 1 || poses[1].joints.size() != 1 ||
      poses[0].joints.begin()->first != poses[1].joints.begin()->first)
    return poses;
  // a continuous motion passes every value in between
  const auto [coordinate, first] = *poses[0].joints.begin();
  const double last = poses[1].joints.begin()->second;
  std::vector<double> values;
  for (int i = 1; i < pose_intervals; ++i) values.push_back(first + (last - first) * i / pose_intervals);
  constexpr double pi = std::numbers::pi;
  const double low = std::min(first, last), high = std::max(first, last);
  // where a crank is in line with the ground; whole turns later nothing is new
  for (const int half_turn : {0, 1})
    if (const double extreme = (std::ceil(low / pi) + half_turn) * pi; extreme < high) values.push_back(extreme);
  for (const double value : values) poses.push_back({{{coordinate, value}}, std::nullopt});
  return poses;
}

class ConditionLister {
 public:
  ConditionLister(const DesignSpace& space, const PlanarLinkage& linkage, const LengthBox& box)
      : space_(space), mechanism_(space.recording->mechanism), linkage_(linkage), box_(box) {}

  void add_pose(const PrescribedPose& pose) {
    known_.clear();
    known_[0] = 1;
    find_directions(pose);
    find_slides(pose);
    std::vector<LoopClosure> relations = linkage_.closures;
    if (relations.size() > max_combined_closures) return;
    const bool has_tool = pose.tool && linkage_.tool;
    if (has_tool) {
      LoopClosure relation = *linkage_.tool;
      relation.ground += LengthPolynomial::constant(linkage_.variables, {-(*pose.tool)[0], -(*pose.tool)[1]});
      relations.push_back(std::move(relation));
    }
    std::size_t combinations = 1;
    for (std::size_t j = 0; j < relations.size(); ++j) combinations *= 3;
    for (std::size_t code = 1; code < combinations; ++code) add_combination(relations, code);
  }

  std::vector<LengthCondition> take() { return std::move(conditions_); }

 private:
  using Coefficient = LengthPolynomial::Coefficient;

  const model::JointOf<Expression>& joint_of(int coordinate) const {
    const JointId joint = mechanism_.coordinates[static_cast<std::size_t>(coordinate)].joint;
    return mechanism_.joints[static_cast<std::size_t>(joint)];
  }
  bool is_length(int coordinate) const {
    return mechanism_.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::length;
  }
  int direction(int body) const { return linkage_.directions[static_cast<std::size_t>(body)]; }
  Coefficient turn(int body) const { return linkage_.turns[static_cast<std::size_t>(body)]; }
  int slides_along(int vector) const { return linkage_.vectors[static_cast<std::size_t>(vector)].slides_along; }

  /// Of all bodies that driven joints connect with the ground.
  void find_directions(const PrescribedPose& pose) {
    for (bool has_found = true; has_found;) {
      has_found = false;
      for (const auto& [coordinate, value] : pose.joints) {
        if (is_length(coordinate)) continue;
        const auto& joint = joint_of(coordinate);
        const auto& rotation = joint.rotation;
        if (!joint.axis[2].is_constant() || !rotation(0, 0).is_constant() || !rotation(1, 0).is_constant()) continue;
        const double angle = joint.axis[2].value() < 0 ? -value : value;
        const Coefficient relative = Coefficient(elementary::cos(angle), elementary::sin(angle)) *
                                     Coefficient(rotation(0, 0).value(), rotation(1, 0).value()) * turn(joint.first) /
                                     turn(joint.second);
        const int first = direction(joint.first), second = direction(joint.second);
        const bool knows_first = known_.count(first) > 0, knows_second = known_.count(second) > 0;
        if (knows_first == knows_second) continue;
        if (knows_first)
          known_[second] = known_[first] * relative;
        else
          known_[first] = known_[second] / relative;
        has_found = true;
      }
    }
  }

  /// Of driven slides along known directions.
  void find_slides(const PrescribedPose& pose) {
    for (const auto& [coordinate, value] : pose.joints) {
      if (!is_length(coordinate)) continue;
      const std::string& name = joint_of(coordinate).name;
      for (int vector = 0; vector < static_cast<int>(linkage_.vectors.size()); ++vector) {
        const auto along = known_.find(slides_along(vector));
        if (along != known_.end() && linkage_.vectors[static_cast<std::size_t>(vector)].name == name)
          known_[vector] = value * along->second;
      }
    }
  }

  void add_combination(const std::vector<LoopClosure>& relations, std::size_t code) {
    VectorSum sum;
    LengthPolynomial known;
    int first = 0;
    for (const LoopClosure& relation : relations) {
      const int sign = static_cast<int>((code % 3 + 1) % 3) - 1;
      code /= 3;
      if (first == 0) first = sign;
      if (sign == 0) continue;
      const LengthPolynomial factor = LengthPolynomial::constant(linkage_.variables, sign);
      sum = sum + relation.links * factor;
      known += relation.ground * factor;
    }
    if (first != 1) return;
    VectorSum links;
    for (const auto& [vector, coefficient] : sum) {
      const auto value = known_.find(vector);
      if (value != known_.end())
        known += coefficient * value->second;
      else if (!coefficient.is_zero())
        links[vector] = coefficient;
    }
    add_links(links, known);
  }

  /// Two unknown vectors: links, or a link and a slide.
  void add_links(const VectorSum& links, const LengthPolynomial& known) {
    std::vector<int> slides;
    for (const auto& [vector, coefficient] : links) {
      (void)coefficient;
      if (slides_along(vector) >= 0) slides.push_back(vector);
    }
    if (slides.empty() && links.size() == 2) add_dyad(links.begin()->second, links.rbegin()->second, known);
    if (slides.size() != 1 || links.size() > 2) return;
    const auto axis = find_polar_form(links.at(slides[0]));
    if (!axis) return;
    const auto along = known_.find(slides_along(slides[0]));
    if (along == known_.end()) {
      // (s u + h) e with an unknown direction e, and nothing else
      const int direction = slides_along(slides[0]);
      if (links.size() == 2 && links.count(direction) == 0) return;
      const LengthPolynomial offset =
          across(links.count(direction) > 0 ? links.at(direction) : LengthPolynomial(), axis->unit);
      add((known * known.conjugate()).real() - offset * offset);
      return;
    }
    if (links.size() == 1) return;
    const int link = links.begin()->first == slides[0] ? links.rbegin()->first : links.begin()->first;
    const auto length = positive_size(links.at(link));
    if (!length) return;
    const LengthPolynomial distance = across(known, axis->unit * along->second);
    add(*length - distance);
    add(*length + distance);
  }

  /// The component at right angles to a unit vector.
  static LengthPolynomial across(const LengthPolynomial& p, Coefficient unit) {
    return (p * (-imaginary_unit * std::conj(unit))).real();
  }

  void add_dyad(const LengthPolynomial& p, const LengthPolynomial& q, const LengthPolynomial& known) {
    const auto a = positive_size(p), b = positive_size(q);
    if (!a || !b) return;
    const auto distance = known.constant_value();
    if (distance) {
      // linear in the links' lengths
      const LengthPolynomial d = LengthPolynomial::constant(linkage_.variables, std::abs(*distance));
      add(*a + *b - d);
      add(*a - *b + d);
      add(*b - *a + d);
      return;
    }
    const LengthPolynomial squared = (known * known.conjugate()).real();
    const LengthPolynomial sum = *a + *b, difference = *a - *b;
    add(sum * sum - squared);
    add(squared - difference * difference);
  }

  std::optional<LengthPolynomial> positive_size(const LengthPolynomial& p) const {
    const auto form = find_polar_form(p);
    if (!form) return {};
    if (enclose_range(form->size, box_).first > 0) return form->size;
    if (enclose_range(form->size, box_).second < 0) return -form->size;
    return {};
  }

  /// Conditions that hold in the whole box are left out, and those that another pose has already.
  void add(LengthPolynomial p) {
    const double size = BernsteinForm({p}).convert(box_).magnitudes[0];
    p += LengthPolynomial::constant(linkage_.variables, reach_tolerance * size);
    if (enclose_range(p, box_).first >= 0) return;
    const auto is_same = [&](const LengthCondition& other) { return other.polynomial.terms() == p.terms(); };
    if (std::any_of(conditions_.begin(), conditions_.end(), is_same)) return;
    conditions_.push_back({std::move(p), false});
  }

  const DesignSpace& space_;
  const MechanismOf<Expression>& mechanism_;
  const PlanarLinkage& linkage_;
  const LengthBox& box_;
  std::map<int, LengthPolynomial::Coefficient> known_;  ///< values of vectors in the pose
  std::vector<LengthCondition> conditions_;
};

/// p = slope · variable + rest ≥ 0, or = 0.
void contract_variable(const LengthCondition& condition, int variable, LengthBox& box) {
  const LengthPolynomial v = LengthPolynomial::variable(static_cast<int>(box.lower.size()), variable);
  const auto found = condition.polynomial.terms().find(v.terms().begin()->first);
  if (found == condition.polynomial.terms().end()) return;
  const double slope = found->second.real();
  const LengthPolynomial rest = condition.polynomial - v * found->second;
  if (rest.has_variable(variable)) return;
  const auto [low, high] = enclose_range(rest, box);
  // slope · v ≥ −high, and for an equality slope · v ≤ −low
  const auto raise = [&](double bound) {
    box.lower[variable] = std::max(box.lower[variable], bound - 1e-15 * std::abs(bound));
  };
  const auto reduce = [&](double bound) {
    box.upper[variable] = std::min(box.upper[variable], bound + 1e-15 * std::abs(bound));
  };
  if (slope > 0) raise(-high / slope);
  if (slope < 0) reduce(-high / slope);
  if (!condition.is_equality) return;
  if (slope > 0) reduce(-low / slope);
  if (slope < 0) raise(-low / slope);
}

}  // namespace

std::vector<LengthCondition> list_assembly_conditions(const DesignSpace& space, const PlanarLinkage& linkage,
                                                      const std::vector<int>& trajectories, const LengthBox& box) {
  ConditionLister lister(space, linkage, box);
  for (const int trajectory : trajectories)
    for (const PrescribedPose& pose : list_poses(space.recording->trajectories[static_cast<std::size_t>(trajectory)]))
      lister.add_pose(pose);
  return lister.take();
}

bool contract(const std::vector<LengthCondition>& conditions, LengthBox& box, std::vector<BoxCut>* cuts) {
  const auto note = [&](const BoxCut& cut) {
    if (cuts != nullptr) cuts->push_back(cut);
  };
  for (int round = 0; round < max_contractions; ++round) {
    const LengthBox before = box;
    for (std::size_t c = 0; c < conditions.size(); ++c) {
      const auto condition = static_cast<int>(c);
      const auto [low, high] = enclose_range(conditions[c].polynomial, box);
      if (high < 0 || (conditions[c].is_equality && low > 0)) {
        note({-1, 0, false, condition});
        return false;
      }
      for (Eigen::Index i = 0; i < box.lower.size(); ++i) {
        const double lower = box.lower[i], upper = box.upper[i];
        const auto length = static_cast<int>(i);
        contract_variable(conditions[c], length, box);
        const bool is_left = box.lower[i] <= box.upper[i];
        if (box.lower[i] > lower && box.lower[i] <= upper) note({length, box.lower[i], true, condition});
        if (is_left && box.upper[i] < upper) note({length, box.upper[i], false, condition});
        if (is_left) continue;
        note({-1, 0, false, condition});
        return false;
      }
    }
    bool has_contracted = false;
    for (Eigen::Index i = 0; i < box.lower.size(); ++i) {
      const double width = before.upper[i] - before.lower[i];
      has_contracted = has_contracted || width - (box.upper[i] - box.lower[i]) > min_contraction * width;
    }
    if (!has_contracted) return true;
  }
  return true;
}

}  // namespace balance::certificate
