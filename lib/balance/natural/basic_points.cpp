#include "balance/natural/basic_points.hpp"

#include <algorithm>
#include <numeric>

namespace balance::natural {

namespace {

constexpr double point_tolerance = 1e-12;  // in characteristic lengths
constexpr double min_base_length = 0.1;
constexpr double min_triangle_height_ratio = 0.2;  // height against base

/// Places of joints on bodies, those of one joint and those at one place of a body grouped together.
class JointPointGroups {
 public:
  explicit JointPointGroups(const Mechanism& mechanism) : length_(characteristic_length(mechanism)) {
    for (const Joint& joint : mechanism.joints) {
      if (joint.type != JointType::revolute && joint.type != JointType::fixed) continue;
      const int first = add(joint.first, joint.point_first);
      join(first, add(joint.second, joint.point_second));
    }
  }

  struct Place {
    BodyId body;
    Complex at;
  };
  const std::vector<Place>& all() const { return places_; }
  int group(int place) const {
    while (parent_[static_cast<std::size_t>(place)] != place) place = parent_[static_cast<std::size_t>(place)];
    return place;
  }

 private:
  int add(BodyId body, const Vector3& point) {
    const Complex at = to_complex(point, length_);
    for (std::size_t k = 0; k < places_.size(); ++k)
      if (places_[k].body == body && std::abs(places_[k].at - at) <= point_tolerance) return static_cast<int>(k);
    places_.push_back({body, at});
    parent_.push_back(static_cast<int>(parent_.size()));
    return parent_.back();
  }
  void join(int a, int b) {
    parent_[static_cast<std::size_t>(std::max(group(a), group(b)))] = std::min(group(a), group(b));
  }

  double length_;
  std::vector<Place> places_;
  std::vector<int> parent_;
};

/// The pair that is farthest apart comes first, then the corner that is highest above it.
void choose_base(BodyPoints& body) {
  std::vector<BodyPoint>& points = body.points;
  std::size_t a = 0, b = 1;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      if (std::abs(points[j].position - points[i].position) >
          (1 + 1e-9) * std::abs(points[b].position - points[a].position))
        a = i, b = j;
  std::swap(points[0], points[a]);
  std::swap(points[1], points[b]);
  if (points.size() < 3) return;
  const Complex base = points[1].position - points[0].position;
  const auto height = [&](const BodyPoint& p) {
    return std::abs(cross(base, p.position - points[0].position)) / std::abs(base);
  };
  const auto top = std::max_element(points.begin() + 2, points.end(),
                                    [&](const auto& p, const auto& q) { return height(p) < height(q) * (1 - 1e-9); });
  std::iter_swap(points.begin() + 2, top);
  body.has_mass_triangle = height(points[2]) > min_triangle_height_ratio * std::abs(base);
}

/// Points in their order: moving joints' points, auxiliary ones, those of the ground.
class BasicPointBuilder {
 public:
  explicit BasicPointBuilder(const Mechanism& mechanism)
      : mechanism_(mechanism),
        places_(mechanism),
        index_(places_.all().size(), -1),
        fixed_(places_.all().size(), false) {
    basic_.length = characteristic_length(mechanism);
    basic_.bodies.resize(mechanism.bodies.size());
    for (int k = 0; k < count(); ++k)
      if (place(k).body == ground) fixed_[group(k)] = true;
  }

  BasicPoints choose() {
    for (int k = 0; k < count(); ++k) number_moving(k);
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) add_auxiliary(b);
    for (int k = 0; k < count(); ++k) number_fixed(k);
    for (int k = 0; k < count(); ++k)
      if (place(k).body != ground)
        basic_.bodies[static_cast<std::size_t>(place(k).body)].points.push_back({index_[group(k)], place(k).at});
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) choose_base(basic_.bodies[b]);
    return std::move(basic_);
  }

 private:
  int count() const { return static_cast<int>(places_.all().size()); }
  const JointPointGroups::Place& place(int k) const { return places_.all()[static_cast<std::size_t>(k)]; }
  std::size_t group(int k) const { return static_cast<std::size_t>(places_.group(k)); }

  std::string name(BodyId body, const std::string& point) const {
    return mechanism_.bodies[static_cast<std::size_t>(body)].name + "." + point;
  }

  std::string label(int k) const {
    for (const NamedPoint& named : mechanism_.bodies[static_cast<std::size_t>(place(k).body)].points)
      if (std::abs(to_complex(named.position, basic_.length) - place(k).at) <= point_tolerance)
        return name(place(k).body, named.name);
    return name(place(k).body, "origin");
  }

  void number_moving(int k) {
    if (fixed_[group(k)] || index_[group(k)] >= 0) return;
    index_[group(k)] = basic_.moving++;
    basic_.names.push_back(label(k));
  }

  void add_auxiliary(std::size_t b) {
    std::vector<Complex> seen;
    for (const JointPointGroups::Place& place : places_.all())
      if (place.body == static_cast<int>(b)) seen.push_back(place.at);
    double spread = 0;
    for (const Complex p : seen)
      for (const Complex q : seen) spread = std::max(spread, std::abs(p - q));
    const auto add = [&](Complex at, const char* suffix) {
      basic_.names.push_back(name(static_cast<int>(b), suffix));
      basic_.bodies[b].points.push_back({basic_.moving++, at});
    };
    if (seen.empty()) add(0, "(1)");
    if (spread < min_base_length) add((seen.empty() ? Complex() : seen.front()) + 1.0, "(2)");
  }

  /// The ground's own place says where the point is.
  void number_fixed(int k) {
    if (place(k).body != ground || index_[group(k)] >= 0) return;
    index_[group(k)] = basic_.count();
    basic_.names.push_back(label(k));
    basic_.fixed.push_back(place(k).at);
  }

  const Mechanism& mechanism_;
  JointPointGroups places_;
  std::vector<int> index_;   ///< per group: its point
  std::vector<bool> fixed_;  ///< per group: the ground has it
  BasicPoints basic_;
};

}  // namespace

BasicPoints choose_basic_points(const Mechanism& mechanism) { return BasicPointBuilder(mechanism).choose(); }

}  // namespace balance::natural
