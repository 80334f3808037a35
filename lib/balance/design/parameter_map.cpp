#include "balance/design/parameter_map.hpp"

#include "balance/base/error.hpp"
#include "balance/design/fit.hpp"

#include <limits>

namespace balance::designing {

ParameterMap::ParameterMap(const Box& box, const DesignProblem& problem, const Survey& survey)
    : box_(box), problem_(problem), loose_(survey.loose), features_(static_cast<int>(survey.base_features.size())) {
  polynomial_ = fit_features(survey, [this](const VectorX& u) { return exact(u); });
}

VectorX ParameterMap::exact(const VectorX& u) const {
  try {
    return designing::features(problem_.mechanism_at(box_.numbers(u)), loose_);
  } catch (const SpecError&) {
    return VectorX::Constant(features_, std::numeric_limits<double>::quiet_NaN());
  }
}

void ParameterMap::evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const {
  if (polynomial_) {
    polynomial_->evaluate(u, values, jacobian);
    return;
  }
  values = exact(u);
  if (jacobian != nullptr) *jacobian = central_differences([this](const VectorX& v) { return exact(v); }, u, features_);
}

}  // namespace balance::designing
