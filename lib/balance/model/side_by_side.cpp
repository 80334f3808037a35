#include "balance/model/side_by_side.hpp"

#include <stdexcept>

namespace balance {

namespace {

class MechanismUnion {
 public:
  explicit MechanismUnion(Mechanism first) : whole_(std::move(first)) {}

  void add(const Mechanism& next) {
    if (next.space != whole_.space || next.gravity != whole_.gravity)
      throw std::invalid_argument("mechanisms side by side are in one space with one gravity");
    bodies_ = static_cast<int>(whole_.bodies.size()) - 1;
    coordinates_ = static_cast<int>(whole_.coordinates.size());
    whole_.bodies.insert(whole_.bodies.end(), next.bodies.begin() + 1, next.bodies.end());
    append(whole_.joints, next.joints, [this](Joint& joint) { join(joint.first, joint.second); });
    append(whole_.couplings, next.couplings, [this](Coupling& coupling) {
      coupling.follower += coordinates_;
      shift(coupling.leader);
    });
    append(whole_.attachments, next.attachments, [this](Attachment& one) { one.body = body(one.body); });
    append(whole_.discs, next.discs, [this](Disc& disc) {
      disc.body = body(disc.body);
      shift(disc.follows);
    });
    append(whole_.loads, next.loads, [this](Load& load) { load.body = body(load.body); });
    append(whole_.springs, next.springs, [this](Spring& spring) {
      join(spring.first, spring.second);
      if (spring.is_joint_spring()) spring.coordinate += coordinates_;
    });
    append(whole_.friction, next.friction, [this](Friction& one) { one.coordinate += coordinates_; });
    append(whole_.actuators, next.actuators, [this](CoordinateId& actuator) { actuator += coordinates_; });
    append(whole_.assembly, next.assembly, [this](CoordinateValue& value) { value.coordinate += coordinates_; });
    whole_.coordinates = list_coordinates(whole_.space, whole_.joints);
  }

  Mechanism finish() { return std::move(whole_); }

 private:
  template <class T, class Shift>
  static void append(std::vector<T>& all, const std::vector<T>& more, const Shift& shift) {
    for (T one : more) {
      shift(one);
      all.push_back(std::move(one));
    }
  }
  BodyId body(BodyId one) const { return one == ground ? one : BodyId(one + bodies_); }
  void shift(CoordinateCombination& what) const {
    for (CoordinateTerm& term : what.terms) term.coordinate += coordinates_;
  }
  void join(BodyId& first, BodyId& second) const {
    first = body(first);
    second = body(second);
  }

  Mechanism whole_;
  int bodies_ = 0, coordinates_ = 0;  ///< that stand before the mechanism that is being added
};

}  // namespace

Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms) {
  if (mechanisms.empty()) throw std::invalid_argument("no mechanism to be put side by side");
  MechanismUnion row(mechanisms.front());
  for (std::size_t i = 1; i < mechanisms.size(); ++i) row.add(mechanisms[i]);
  return row.finish();
}

}  // namespace balance
