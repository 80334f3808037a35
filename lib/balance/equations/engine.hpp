#pragma once
/// What EquationTerms is made of, for the plane and for space. Private to equations.

#include "balance/dynamics/actuation.hpp"
#include "balance/dynamics/external.hpp"
#include "balance/equations/equation_terms.hpp"
#include "balance/inverse/branch.hpp"

namespace balance {

class EquationTerms::Engine {
 public:
  Engine(Mechanism given, const InverseOptions& wishes) : mechanism(std::move(given)), options(wishes) {}
  virtual ~Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  virtual MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) = 0;
  virtual MotionOutcome independent_terms(const double* q, double time, IndependentTerms& out) = 0;
  virtual MotionOutcome redundant_terms(const double* q, double time, RedundantTerms& out) = 0;
  /// Speeds per rate of the independent coordinates, and per speed what rates alone make of its derivative.
  virtual MotionOutcome speed_rows(const double* q, const std::vector<Speed>& speeds, MatrixX& rows,
                                   std::vector<MatrixX>& forms) = 0;
  virtual MotionOutcome split(const double* q, const double* dq, const double* ddq, double time, EffortSplit& out) = 0;

  const Mechanism mechanism;
  const InverseOptions options;
  std::vector<CoordinateId> independent;
  std::vector<std::string> redundant, closures, notes;
  std::vector<bool> redundant_lengths;
};

template <class S>
class TermsEngine final : public EquationTerms::Engine {
 public:
  TermsEngine(const Mechanism& mechanism, const InverseOptions& options);

  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) override;
  MotionOutcome independent_terms(const double* q, double time, IndependentTerms& out) override;
  MotionOutcome redundant_terms(const double* q, double time, RedundantTerms& out) override;
  MotionOutcome speed_rows(const double* q, const std::vector<Speed>& speeds, MatrixX& rows,
                           std::vector<MatrixX>& forms) override;
  MotionOutcome split(const double* q, const double* dq, const double* ddq, double time, EffortSplit& out) override;

 private:
  void name_tree();
  MotionOutcome go(const double* q);
  VectorX inertial_forces(const VectorX& dy, const VectorX& ddy, bool weight);
  VectorX external_forces(const ExternalForces<S>& forces, double time);
  RestTerms rest_terms(double time);
  MatrixX mass_matrix();
  MatrixX viscous_friction() const;
  MatrixX input() const;
  MatrixX constraints();
  VectorX acceleration_at(const VectorX& rates, VectorX& dy);
  std::vector<MatrixX> tree_velocity_terms();
  MotionOutcome projection(double time, MatrixX& matrix);

  Branch<S> branch_;
  Actuation<S> actuation_;
  Mechanism only_loads_, only_springs_;
  ExternalForces<S> loads_, springs_;
  System<S> closure_system_;
  typename S::Vector gravity_;
  std::vector<Wrench<S>> wrenches_;
  int columns_, freedoms_;
  MatrixX C_;
};

extern template class TermsEngine<Planar>;
extern template class TermsEngine<Spatial>;

}  // namespace balance
