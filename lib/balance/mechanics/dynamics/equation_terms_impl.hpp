#pragma once
/// Implementation of EquationTerms, for the plane and for space.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/kinematics/assembly_branch.hpp"

#include <vector>

namespace balance::dynamics {

// Functions of rates that are quadratic forms or, if constraints on speeds have values, quadratic, linear and constant.

/// f_k(r) = rᵀ Q_k r + (L r)_k + c_k.
struct RateFunctions {
  std::vector<MatrixX> quadratic;  ///< per function, symmetric
  MatrixX linear;                  ///< functions × rates; empty: zero, and so is `constant`
  VectorX constant;

  /// The same functions of the rates s with r = V s + offset. @param offset empty: zero
  RateFunctions substitute(const MatrixX& V, const VectorX& offset) const;
};

class EquationTerms::Implementation {
 public:
  Implementation(Mechanism source_mechanism, const InverseOptions& requested_options)
      : mechanism(std::move(source_mechanism)), options(requested_options) {}
  virtual ~Implementation() = default;
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  virtual MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) = 0;
  virtual MotionOutcome independent_terms(const double* q, double time, IndependentTerms& out) = 0;
  virtual MotionOutcome redundant_terms(const double* q, double time, RedundantTerms& out) = 0;
  /// Generalised speeds as functions of the rates of the independent coordinates.
  /// @param rows their Jacobian @param offset their values at zero rates; empty: zero
  /// @param products what their time derivatives contain at zero accelerations
  virtual MotionOutcome speed_rows(const double* q, double time, const std::vector<model::GeneralisedSpeed>& speeds,
                                   MatrixX& rows, VectorX& offset, RateFunctions& products) = 0;
  virtual MotionOutcome split(const double* q, const double* dq, const double* ddq, double time,
                              EffortBreakdown& out) = 0;

  const Mechanism mechanism;
  const InverseOptions options;
  std::vector<CoordinateId> independent;
  std::vector<std::string> redundant, closures, disc_rows, notes;
  std::vector<bool> redundant_lengths;  ///< per redundant coordinate: whether it is a length
};

template <class S>
class EquationTermsOf final : public EquationTerms::Implementation {
 public:
  EquationTermsOf(const Mechanism& mechanism, const InverseOptions& options);

  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) override;
  MotionOutcome independent_terms(const double* q, double time, IndependentTerms& out) override;
  MotionOutcome redundant_terms(const double* q, double time, RedundantTerms& out) override;
  MotionOutcome speed_rows(const double* q, double time, const std::vector<model::GeneralisedSpeed>& speeds,
                           MatrixX& rows, VectorX& offset, RateFunctions& products) override;
  MotionOutcome split(const double* q, const double* dq, const double* ddq, double time, EffortBreakdown& out) override;

 private:
  void name_tree_coordinates();
  MotionOutcome move_to(const double* q, double time);
  VectorX inverse_dynamics_forces(const VectorX& dy, const VectorX& ddy, bool weight);
  VectorX external_forces(const ExternalForces<S>& forces, double time);
  StaticTerms compute_static_terms(double time);
  MatrixX mass_matrix();
  VectorX friction_forces(const VectorX& dy, double time);
  MatrixX viscous_friction();
  MatrixX input_matrix() const;
  MatrixX constraint_matrix();
  MatrixX disc_transformation();
  VectorX compute_velocity_product_acceleration(const VectorX& rates, VectorX& dy);
  std::vector<MatrixX> tree_velocity_terms();
  MotionOutcome projection(double time, MatrixX& matrix);

  kinematics::AssemblyBranch<S> branch_;
  Actuation<S> actuation_;
  Mechanism only_loads_, only_springs_, only_dampers_;
  ExternalForces<S> loads_, springs_, dampers_;
  kinematics::ConstraintSystem<S> closure_system_;
  typename S::Vector gravity_;
  std::vector<Wrench<S>> wrenches_;
  int columns_, freedoms_;
  bool has_prescribed_speeds_;
  MatrixX C_;  ///< Φ C = 0, columns × independent coordinates
};

extern template class EquationTermsOf<kinematics::Planar>;
extern template class EquationTermsOf<kinematics::Spatial>;

// Quadratic forms of rates.

/// Quadratic forms from their values at unit vectors and at sums of two of these, exact to round-off.
/// @param evaluate returns the values of all forms at given rates
template <class Values>
std::vector<MatrixX> polarise_quadratic_form(int size, const Values& evaluate) {
  std::vector<VectorX> unit_values;
  for (int r = 0; r < size; ++r) unit_values.push_back(evaluate(VectorX::Unit(size, r)));
  if (unit_values.empty()) return {};
  std::vector<MatrixX> forms(static_cast<std::size_t>(unit_values.front().size()), MatrixX(size, size));
  for (int r = 0; r < size; ++r)
    for (int s = 0; s <= r; ++s) {
      const VectorX value =
          r == s ? unit_values[static_cast<std::size_t>(r)]
                 : VectorX((evaluate(VectorX::Unit(size, r) + VectorX::Unit(size, s)) -
                            unit_values[static_cast<std::size_t>(r)] - unit_values[static_cast<std::size_t>(s)]) /
                           2);
      for (std::size_t k = 0; k < forms.size(); ++k)
        forms[k](r, s) = forms[k](s, r) = value[static_cast<Eigen::Index>(k)];
    }
  return forms;
}

/// Functions of rates from their values. @param is_quadratic whether they are quadratic forms
template <class Values>
RateFunctions expand_in_rates(int size, bool is_quadratic, const Values& evaluate) {
  if (is_quadratic) return {polarise_quadratic_form(size, evaluate), {}, {}};
  RateFunctions functions;
  functions.constant = evaluate(VectorX::Zero(size));
  functions.linear.resize(functions.constant.size(), size);
  for (int k = 0; k < size; ++k)
    functions.linear.col(k) = (evaluate(VectorX::Unit(size, k)) - evaluate(-VectorX::Unit(size, k))) / 2;
  functions.quadratic = polarise_quadratic_form(size, [&](const VectorX& rates) {
    return VectorX(evaluate(rates) - functions.linear * rates - functions.constant);
  });
  return functions;
}

}  // namespace balance::dynamics
