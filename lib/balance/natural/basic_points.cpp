#include "balance/natural/basic_points.hpp"

#include <algorithm>
#include <numeric>

namespace balance::natural {

namespace {

constexpr double same_place = 1e-12;  // in characteristic lengths
constexpr double shortest_base = 0.1;
constexpr double flattest_triangle = 0.2;  // height against base

/// Places of joints on bodies, those of one joint and those at one place of a body grouped together.
class Places {
 public:
  explicit Places(const Mechanism& mechanism) : length_(characteristic_length(mechanism)) {
    for (const Joint& joint : mechanism.joints) {
      if (joint.type != JointType::revolute && joint.type != JointType::fixed) continue;
      const int first = add(joint.first, joint.point_first);
      join(first, add(joint.second, joint.point_second));
    }
  }

  struct Place {
    int body;
    Complex at;
  };
  const std::vector<Place>& all() const { return places_; }
  int group(int place) const {
    while (parent_[static_cast<std::size_t>(place)] != place) place = parent_[static_cast<std::size_t>(place)];
    return place;
  }

 private:
  int add(int body, const Vector3& point) {
    const Complex at = planar(point, length_);
    for (std::size_t k = 0; k < places_.size(); ++k)
      if (places_[k].body == body && std::abs(places_[k].at - at) <= same_place) return static_cast<int>(k);
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
      if (std::abs(points[j].place - points[i].place) > (1 + 1e-9) * std::abs(points[b].place - points[a].place))
        a = i, b = j;
  std::swap(points[0], points[a]);
  std::swap(points[1], points[b]);
  if (points.size() < 3) return;
  const Complex base = points[1].place - points[0].place;
  const auto height = [&](const BodyPoint& p) {
    return std::abs(cross(base, p.place - points[0].place)) / std::abs(base);
  };
  const auto top = std::max_element(points.begin() + 2, points.end(),
                                    [&](const auto& p, const auto& q) { return height(p) < height(q) * (1 - 1e-9); });
  std::iter_swap(points.begin() + 2, top);
  body.triangle = height(points[2]) > flattest_triangle * std::abs(base);
}

}  // namespace

BasicPoints choose_points(const Mechanism& mechanism) {
  BasicPoints basic;
  basic.length = characteristic_length(mechanism);
  basic.bodies.resize(mechanism.bodies.size());
  const Places places(mechanism);
  const int count = static_cast<int>(places.all().size());
  std::vector<int> index(places.all().size(), -1);  // of the group's point
  std::vector<bool> fixed(places.all().size(), false);
  for (int k = 0; k < count; ++k)
    if (places.all()[static_cast<std::size_t>(k)].body == ground)
      fixed[static_cast<std::size_t>(places.group(k))] = true;
  const auto name = [&](int body, const std::string& point) {
    return mechanism.bodies[static_cast<std::size_t>(body)].name + "." + point;
  };
  const auto label = [&](int k) {
    const Places::Place& place = places.all()[static_cast<std::size_t>(k)];
    for (const NamedPoint& named : mechanism.bodies[static_cast<std::size_t>(place.body)].points)
      if (std::abs(planar(named.position, basic.length) - place.at) <= same_place) return name(place.body, named.name);
    return name(place.body, "origin");
  };
  // moving groups first
  for (int k = 0; k < count; ++k) {
    const auto g = static_cast<std::size_t>(places.group(k));
    if (fixed[g] || index[g] >= 0) continue;
    index[g] = basic.moving++;
    basic.names.push_back(label(k));
  }
  for (int k = 0; k < count; ++k) {
    const auto g = static_cast<std::size_t>(places.group(k));
    const Places::Place& place = places.all()[static_cast<std::size_t>(k)];
    if (!fixed[g] && place.body != ground)
      basic.bodies[static_cast<std::size_t>(place.body)].points.push_back({index[g], place.at});
  }
  // auxiliary points are moving ones; the ground's points come behind them all
  std::vector<std::vector<std::pair<std::size_t, Complex>>> grounded(mechanism.bodies.size());
  for (int k = 0; k < count; ++k) {
    const auto g = static_cast<std::size_t>(places.group(k));
    const Places::Place& place = places.all()[static_cast<std::size_t>(k)];
    if (fixed[g] && place.body != ground) grounded[static_cast<std::size_t>(place.body)].push_back({g, place.at});
  }
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    std::vector<Complex> seen;
    for (const BodyPoint& p : basic.bodies[b].points) seen.push_back(p.place);
    for (const auto& [g, at] : grounded[b]) seen.push_back(at);
    double spread = 0;
    for (const Complex p : seen)
      for (const Complex q : seen) spread = std::max(spread, std::abs(p - q));
    const auto add = [&](Complex at, const char* suffix) {
      basic.names.push_back(name(static_cast<int>(b), suffix));
      basic.bodies[b].points.push_back({basic.moving++, at});
    };
    if (seen.empty()) add(0, "(1)");
    if (spread < shortest_base) add((seen.empty() ? Complex() : seen.front()) + 1.0, "(2)");
  }
  for (int k = 0; k < count; ++k) {
    const auto g = static_cast<std::size_t>(k);
    if (places.group(k) != k || !fixed[g]) continue;
    index[g] = basic.count();
    basic.names.push_back(label(k));
    for (int p = 0; p < count; ++p)  // the ground's own place decides
      if (places.group(p) == k && places.all()[static_cast<std::size_t>(p)].body == ground) {
        basic.fixed.push_back(places.all()[static_cast<std::size_t>(p)].at);
        basic.names.back() = label(p);
        break;
      }
  }
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    for (const auto& [g, at] : grounded[b]) basic.bodies[b].points.push_back({index[g], at});
    choose_base(basic.bodies[b]);
  }
  return basic;
}

}  // namespace balance::natural
