#include "balance/natural/form.hpp"

namespace balance::natural {

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
    bool known = false;
    for (PointTerm& mine : a.terms)
      if (mine.point == term.point) mine.weight += term.weight, known = true;
    if (!known) a.terms.push_back(term);
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

}  // namespace balance::natural
