#include "balance/synthesis/verification/natural_points.hpp"

#include <algorithm>
#include <numeric>

namespace balance::verification::natural {

void NaturalCoordinates::add(double factor, const VectorX& unknowns) {
  const auto moving = (unknowns.size() - static_cast<Eigen::Index>(scalars.size())) / 2;
  for (Eigen::Index k = 0; k < moving; ++k)
    points[static_cast<std::size_t>(k)] += factor * Complex(unknowns[2 * k], unknowns[2 * k + 1]);
  for (std::size_t s = 0; s < scalars.size(); ++s)
    scalars[s] += factor * unknowns[2 * moving + static_cast<Eigen::Index>(s)];
}

void NaturalCoordinates::set(const VectorX& unknowns) {
  std::fill(points.begin(), points.end(), Complex());
  std::fill(scalars.begin(), scalars.end(), 0);
  add(1, unknowns);
}

Complex AffineForm::at(const NaturalCoordinates& position) const { return constant + rate(position); }

Complex AffineForm::rate(const NaturalCoordinates& rates) const {
  Complex sum;
  for (const PointTerm& term : terms) sum += term.weight * rates.points[static_cast<std::size_t>(term.point)];
  return sum;
}

AffineForm operator+(AffineForm a, const AffineForm& b) {
  a.constant += b.constant;
  for (const PointTerm& term : b.terms) {
    bool is_merged = false;
    for (PointTerm& existing : a.terms)
      if (existing.point == term.point) existing.weight += term.weight, is_merged = true;
    if (!is_merged) a.terms.push_back(term);
  }
  return a;
}

AffineForm operator-(const AffineForm& a, const AffineForm& b) { return a + Complex(-1) * b; }

AffineForm operator*(Complex factor, AffineForm form) {
  form.constant *= factor;
  for (PointTerm& term : form.terms) term.weight *= factor;
  return form;
}

AffineForm make_constant_form(Complex value) { return {value, {}}; }

double ConstraintRow::value(const NaturalCoordinates& position) const {
  if (angle >= 0)
    return cross(make_unit_complex(position.scalars[static_cast<std::size_t>(angle)]), right.at(position));
  double sum = dot(left.at(position), right.at(position)) - constant;
  for (const ScalarTerm& term : scalars)
    sum += term.coefficient * position.scalars[static_cast<std::size_t>(term.scalar)];
  return sum;
}

void ConstraintRow::gradient(const NaturalCoordinates& position, int moving_points,
                             Eigen::Ref<Eigen::RowVectorXd> out) const {
  out.setZero();
  // Re(conj(c) w ż) = Re(conj(conj(w) c) ż)
  const auto add = [&](const AffineForm& form, Complex partner) {
    for (const PointTerm& term : form.terms) {
      if (term.point >= moving_points) continue;
      const Complex slope = std::conj(term.weight) * partner;
      out[2 * term.point] += slope.real();
      out[2 * term.point + 1] += slope.imag();
    }
  };
  if (angle >= 0) {
    const Complex unit = make_unit_complex(position.scalars[static_cast<std::size_t>(angle)]);
    add(right, imaginary * unit);
    out[2 * moving_points + angle] -= dot(unit, right.at(position));
    return;
  }
  if (!right.terms.empty()) add(right, left.at(position));
  if (!left.terms.empty()) add(left, right.at(position));
  for (const ScalarTerm& term : scalars) out[2 * moving_points + term.scalar] += term.coefficient;
}

double ConstraintRow::rate(const NaturalCoordinates& position, const NaturalCoordinates& velocity) const {
  if (angle >= 0) {
    const auto a = static_cast<std::size_t>(angle);
    const Complex unit = make_unit_complex(position.scalars[a]);
    return cross(unit, right.rate(velocity)) - velocity.scalars[a] * dot(unit, right.at(position));
  }
  double sum = dot(left.rate(velocity), right.at(position)) + dot(left.at(position), right.rate(velocity));
  for (const ScalarTerm& term : scalars)
    sum += term.coefficient * velocity.scalars[static_cast<std::size_t>(term.scalar)];
  return sum;
}

double ConstraintRow::bias(const NaturalCoordinates& position, const NaturalCoordinates& velocity) const {
  if (angle < 0) return 2 * dot(left.rate(velocity), right.rate(velocity));
  const auto a = static_cast<std::size_t>(angle);
  const Complex unit = make_unit_complex(position.scalars[a]);
  const double spin = velocity.scalars[a];
  return -2 * spin * dot(unit, right.rate(velocity)) - spin * spin * cross(unit, right.at(position));
}

double ConstraintRow::second_rate(const NaturalState& state) const {
  const NaturalCoordinates &z = state.position, &dz = state.velocity, &ddz = state.acceleration;
  // the part linear in accelerations has the same shape as the rate
  return rate(z, ddz) + bias(z, dz);
}

namespace {

constexpr double point_tolerance = 1e-12;  // in characteristic lengths
constexpr double min_base_length = 0.1;
constexpr double min_triangle_height_ratio = 0.2;  // relative to the base

/// Places of joints on bodies; those of one joint, and those at one place of a body, form a group.
class JointPointGroups {
 public:
  explicit JointPointGroups(const Mechanism& mechanism) : length_(characteristic_length(mechanism)) {
    for (const Joint& joint : mechanism.joints) {
      if (joint.type != JointType::revolute && joint.type != JointType::fixed) continue;
      const int first = add(joint.first, joint.point_first);
      merge(first, add(joint.second, joint.point_second));
    }
  }

  struct JointPoint {
    BodyId body;
    Complex position;
  };
  const std::vector<JointPoint>& points() const { return points_; }
  int group(int point_index) const {
    while (parent_[static_cast<std::size_t>(point_index)] != point_index)
      point_index = parent_[static_cast<std::size_t>(point_index)];
    return point_index;
  }

 private:
  int add(BodyId body, const Vector3& point) {
    const Complex position = to_complex(point, length_);
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (points_[k].body == body && std::abs(points_[k].position - position) <= point_tolerance)
        return static_cast<int>(k);
    points_.push_back({body, position});
    parent_.push_back(static_cast<int>(parent_.size()));
    return parent_.back();
  }
  void merge(int a, int b) {
    parent_[static_cast<std::size_t>(std::max(group(a), group(b)))] = std::min(group(a), group(b));
  }

  double length_;
  std::vector<JointPoint> points_;
  std::vector<int> parent_;
};

/// The two points with the maximum distance come first, then the one with the maximum height above them.
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
  const auto highest = std::max_element(points.begin() + 2, points.end(), [&](const auto& p, const auto& q) {
    return height(p) < height(q) * (1 - 1e-9);
  });
  std::iter_swap(points.begin() + 2, highest);
  body.has_mass_triangle = height(points[2]) > min_triangle_height_ratio * std::abs(base);
}

/// Numbers the points: moving joints' points, auxiliary ones, those of the ground.
class BasicPointBuilder {
 public:
  explicit BasicPointBuilder(const Mechanism& mechanism)
      : mechanism_(mechanism),
        groups_(mechanism),
        index_(groups_.points().size(), -1),
        fixed_(groups_.points().size(), false) {
    basic_.length = characteristic_length(mechanism);
    basic_.bodies.resize(mechanism.bodies.size());
    for (int k = 0; k < count(); ++k)
      if (joint_point(k).body == model::ground) fixed_[group(k)] = true;
  }

  BasicPoints choose() {
    for (int k = 0; k < count(); ++k) number_moving(k);
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) add_auxiliary(b);
    for (int k = 0; k < count(); ++k) number_fixed(k);
    for (int k = 0; k < count(); ++k)
      if (joint_point(k).body != model::ground)
        basic_.bodies[static_cast<std::size_t>(joint_point(k).body)].points.push_back(
            {index_[group(k)], joint_point(k).position});
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) choose_base(basic_.bodies[b]);
    return std::move(basic_);
  }

 private:
  int count() const { return static_cast<int>(groups_.points().size()); }
  const JointPointGroups::JointPoint& joint_point(int k) const { return groups_.points()[static_cast<std::size_t>(k)]; }
  std::size_t group(int k) const { return static_cast<std::size_t>(groups_.group(k)); }

  std::string name(BodyId body, const std::string& point) const {
    return mechanism_.bodies[static_cast<std::size_t>(body)].name + "." + point;
  }

  std::string label(int k) const {
    for (const model::NamedPoint& named : mechanism_.bodies[static_cast<std::size_t>(joint_point(k).body)].points)
      if (std::abs(to_complex(named.position, basic_.length) - joint_point(k).position) <= point_tolerance)
        return name(joint_point(k).body, named.name);
    return name(joint_point(k).body, "origin");
  }

  void number_moving(int k) {
    if (fixed_[group(k)] || index_[group(k)] >= 0) return;
    index_[group(k)] = basic_.moving++;
    basic_.names.push_back(label(k));
  }

  void add_auxiliary(std::size_t b) {
    std::vector<Complex> body_points;
    for (const JointPointGroups::JointPoint& candidate : groups_.points())
      if (candidate.body == static_cast<int>(b)) body_points.push_back(candidate.position);
    double spread = 0;
    for (const Complex p : body_points)
      for (const Complex q : body_points) spread = std::max(spread, std::abs(p - q));
    const auto add = [&](Complex position, const char* suffix) {
      basic_.names.push_back(name(static_cast<int>(b), suffix));
      basic_.bodies[b].points.push_back({basic_.moving++, position});
    };
    if (body_points.empty()) add(0, "(1)");
    if (spread < min_base_length) add((body_points.empty() ? Complex() : body_points.front()) + 1.0, "(2)");
  }

  /// The position of a fixed point is that on the ground.
  void number_fixed(int k) {
    if (joint_point(k).body != model::ground || index_[group(k)] >= 0) return;
    index_[group(k)] = basic_.count();
    basic_.names.push_back(label(k));
    basic_.fixed.push_back(joint_point(k).position);
  }

  const Mechanism& mechanism_;
  JointPointGroups groups_;
  std::vector<int> index_;   ///< per group: its point
  std::vector<bool> fixed_;  ///< per group: whether it belongs to the ground
  BasicPoints basic_;
};

}  // namespace

BasicPoints choose_basic_points(const Mechanism& mechanism) { return BasicPointBuilder(mechanism).choose(); }

}  // namespace balance::verification::natural
