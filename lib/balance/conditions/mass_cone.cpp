#include "balance/conditions/mass_cone.hpp"

#include <algorithm>
#include <string_view>

namespace balance {

ParameterSign parameter_sign(const Parameter& parameter) {
  switch (parameter.kind) {
    case ParameterKind::known_term: return ParameterSign::positive;
    case ParameterKind::mass:
    case ParameterKind::moment_of_inertia:
      return parameter.owner_kind == ParameterOwner::body ? ParameterSign::positive : ParameterSign::not_negative;
    case ParameterKind::stiffness:
    case ParameterKind::viscous:
    case ParameterKind::coulomb: return ParameterSign::not_negative;
    case ParameterKind::first_moment:
    case ParameterKind::product_of_inertia:
    case ParameterKind::stiffness_moment:
    case ParameterKind::force:
    case ParameterKind::couple: return ParameterSign::indefinite;
  }
  return ParameterSign::indefinite;
}

bool is_always_zero(const Parameter& parameter) {
  return parameter.owner_kind == ParameterOwner::disc && parameter.kind == ParameterKind::first_moment;
}

MatrixX PseudoInertiaBlock::matrix(const VectorX& coefficients) const {
  MatrixX sum = MatrixX::Zero(size, size);
  for (const Term& term : terms) sum += coefficients[term.parameter] * term.matrix;
  return sum;
}

VectorX PseudoInertiaBlock::bilinear_form_row(const VectorX& u, const VectorX& v, Eigen::Index parameters) const {
  VectorX row = VectorX::Zero(parameters);
  for (const Term& term : terms) row[term.parameter] = u.dot(term.matrix * v);
  return row;
}

namespace {

/// Place of a letter among the coordinates.
Eigen::Index axis(char letter) { return letter - 'x'; }

/// The quadratic part of a moment or product of inertia, as a form in the place: Ixx = ∫(y² + z²), Ixy = −∫xy, J = ∫(x² + y²).
MatrixX second_moment_form(std::string_view symbol, Eigen::Index dimension) {
  MatrixX form = MatrixX::Zero(dimension, dimension);
  if (symbol == "J") return MatrixX::Identity(dimension, dimension);
  const Eigen::Index i = axis(symbol[1]), j = axis(symbol[2]);
  if (i == j) {
    form.setIdentity();
    form(i, i) = 0;
  } else {
    form(i, j) = form(j, i) = -0.5;
  }
  return form;
}

/// The block of one body, attachment or disc with the parameters first … last − 1. The last row belongs to the constant 1.
PseudoInertiaBlock inertia_block(const std::vector<Parameter>& parameters, std::size_t first, std::size_t last) {
  const Eigen::Index dimension = last - first > 4 ? 3 : 2;
  PseudoInertiaBlock block{dimension + 1, parameters[first].owner_kind == ParameterOwner::body, {}};
  for (std::size_t p = first; p < last; ++p) {
    const Parameter& parameter = parameters[p];
    if (is_always_zero(parameter)) continue;
    MatrixX form = MatrixX::Zero(dimension + 1, dimension + 1);
    if (parameter.kind == ParameterKind::mass) {
      form(dimension, dimension) = 1;
    } else if (parameter.kind == ParameterKind::first_moment) {
      const Eigen::Index i = axis(parameter.symbol[1]);
      form(i, dimension) = form(dimension, i) = 0.5;
    } else {
      form.topLeftCorner(dimension, dimension) = second_moment_form(parameter.symbol, dimension);
    }
    block.terms.push_back({static_cast<Eigen::Index>(p), form});
  }
  return block;
}

}  // namespace

PseudoInertiaCone::PseudoInertiaCone(const std::vector<Parameter>& parameters) {
  for (std::size_t first = 0; first < parameters.size();) {
    const Parameter& head = parameters[first];
    std::size_t last = first;
    while (last < parameters.size() && parameters[last].owner_kind == head.owner_kind &&
           parameters[last].index == head.index)
      ++last;
    if (head.kind == ParameterKind::known_term) {
      blocks.push_back({1, true, {{static_cast<Eigen::Index>(first), MatrixX::Ones(1, 1)}}});
    } else if (head.owner_kind == ParameterOwner::load || head.owner_kind == ParameterOwner::friction) {
      for (std::size_t p = first; p < last; ++p) excluded.push_back(static_cast<Eigen::Index>(p));
    } else if (head.owner_kind != ParameterOwner::spring) {
      blocks.push_back(inertia_block(parameters, first, last));
    } else {
      blocks.push_back({1, false, {{static_cast<Eigen::Index>(first), MatrixX::Ones(1, 1)}}});
      for (std::size_t p = first + 1; p < last; ++p) excluded.push_back(static_cast<Eigen::Index>(p));
    }
    first = last;
  }
}

}  // namespace balance
