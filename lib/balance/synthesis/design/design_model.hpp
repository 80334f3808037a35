#pragma once
/// Interface to everything that can be computed for a design from values of its free numbers: the mechanism, its
/// conditions, its figures.

#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::design {

/// weight · the maximum of several smooth functions of the free numbers.
struct MaxTerm {
  double weight = 1;
  VectorX values;
  MatrixX jacobian;  ///< functions × free numbers
};

/// A figure as a function either of the mechanism's parameters alone (cheap, because the motion stays the same) or of
/// the free numbers (by simulation, if the motion itself depends on them).
class DesignFunction {
 public:
  enum class Domain { parameters, variables };

  virtual ~DesignFunction() = default;
  virtual Domain domain() const = 0;
  /// @param at the parameters in the order of Conditions::parameters, or the free numbers [SI]
  /// @param gradient set unless null; only for functions of the parameters
  /// @return NaN if undefined: such points are not designs
  virtual double evaluate(const VectorX& at, VectorX* gradient) const = 0;
  /// Whether max_terms is implemented.
  virtual bool has_max_terms() const { return false; }
  /// The function as a sum of maxima with derivatives; std::nullopt if it has no value. Requires has_max_terms.
  virtual std::optional<std::vector<MaxTerm>> max_terms(const VectorX& x) const;
  /// The gradient at the free numbers x; std::nullopt if it is only available by differences.
  virtual std::optional<VectorX> gradient(const VectorX& x) const;
  /// Why there is no value at the free numbers x, as a sentence. May be empty.
  virtual std::string failure_reason(const VectorX& x) const;
};

/// The gradient of a sum of maxima; std::nullopt if it does not exist or is not finite.
std::optional<VectorX> max_term_gradient(const std::optional<std::vector<MaxTerm>>& terms, Eigen::Index variables);

/// A figure to be minimised.
struct Objective {
  std::string name;  ///< "added mass", "rms(torque) along cycloid"
  std::string unit;
  std::shared_ptr<const DesignFunction> function;
  bool is_convex = false;     ///< whether it is a convex function of the parameters
  bool is_concave = false;    ///< whether it is a concave function of the parameters
  bool is_secondary = false;  ///< a property of the design (added mass) and not of its motion, minimal if nothing is
                              ///< balanced; a compromise then first minimises the residual of the conditions
  bool is_constant = false;   ///< for all values of the parameters
  double lower_bound = -std::numeric_limits<double>::infinity();  ///< of all values

  bool is_of_parameters() const { return function->domain() == DesignFunction::Domain::parameters; }
};

/// A limit on a figure.
struct DesignLimit {
  std::string text;  ///< "peak(torque) <= 12"
  Objective figure;
  bool is_lower = false;  ///< lower limit; else upper limit
  double bound = 0;       ///< [SI]
};

/// Σ figures ≤ bound, for figures that are functions of the parameters; a lower limit has both signs reversed.
struct ConvexLimit {
  std::vector<AffineFigure> figures;
  double bound = 0;  ///< [SI]
};

/// Number of samples of a motion: as required by a search over lengths, or as specified by the trajectory.
enum class FigureSampling { coarse, full };

/// Builds mechanisms from values of the free numbers, and provides what is known about their figures. x: the free
/// numbers in the order of DesignProblem::variables [SI]. Every method may throw SpecError if an expression of the spec
/// has no value.
class DesignModel {
 public:
  /// What a model provides beyond the mechanism; optional methods may be called only if their capability is set.
  struct Capabilities {
    bool has_convex_terms = false;      ///< convex_terms is implemented, and all of its terms are convex
    bool has_affine_terms = false;      ///< it is implemented; some may be other statistics of affine quantities
    bool has_convex_limits = false;     ///< convex_limits is implemented
    bool are_all_limits_convex = true;  ///< convex_limits covers all limits of the problem, if any
    /// convex_terms with coarse sampling and convex_limits have all samples of the figures themselves.
    bool are_samples_complete = false;
    bool can_fix_geometry = false;  ///< objective_at_geometry and limits_at_geometry are implemented
  };

  virtual ~DesignModel() = default;
  virtual Capabilities capabilities() const { return {}; }
  /// The mechanism at values within their bounds; not checked for validity.
  virtual Mechanism build_mechanism(const VectorX& x) const = 0;
  /// The first issue (find_validation_issue) of the mechanism, as a sentence; empty if it is valid. Invalid mechanisms
  /// are not designs.
  virtual std::string invalidity_reason(const VectorX& x) const;
  /// Why x is not a feasible design regardless of balance: the mechanism cannot be assembled or cannot perform a
  /// required motion. Empty if nothing rules it out. Called if lengths or ratios are free.
  virtual std::string infeasibility_reason(const VectorX& x) const;
  /// By default, the complete conditions (balance::derive_conditions).
  virtual Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                       const ConditionOptions& options) const;
  /// The terms of the objective for the lengths and motion of x, as functions of the parameters. std::nullopt if there
  /// is no motion.
  virtual std::optional<std::vector<AffineFigure>> convex_terms(const VectorX& x, FigureSampling sampling) const;
  /// The convex limits for the lengths and motion of x. A limit that applies to every load case yields one for each,
  /// and all of them must hold.
  virtual std::optional<std::vector<ConvexLimit>> convex_limits(const VectorX& x) const;
  /// The objective if only the variables `free` change and the others stay as in x; it may have properties that the
  /// full objective lacks.
  virtual Objective objective_at_geometry(const VectorX& x, const std::vector<int>& free,
                                          const dynamics::FreeSprings& loose) const;
  virtual std::vector<DesignLimit> limits_at_geometry(const VectorX& x, const std::vector<int>& free,
                                                      const dynamics::FreeSprings& loose) const;
};

/// Forwards to another model everything that a derived class does not override.
class DesignModelDecorator : public DesignModel {
 public:
  explicit DesignModelDecorator(std::shared_ptr<const DesignModel> model) : model_(std::move(model)) {}

  Capabilities capabilities() const override { return model_->capabilities(); }
  Mechanism build_mechanism(const VectorX& x) const override { return model_->build_mechanism(x); }
  std::string invalidity_reason(const VectorX& x) const override { return model_->invalidity_reason(x); }
  std::string infeasibility_reason(const VectorX& x) const override { return model_->infeasibility_reason(x); }
  Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                               const ConditionOptions& options) const override {
    return model_->derive_conditions(mechanism, goals, options);
  }
  std::optional<std::vector<AffineFigure>> convex_terms(const VectorX& x, FigureSampling sampling) const override {
    return model_->convex_terms(x, sampling);
  }
  std::optional<std::vector<ConvexLimit>> convex_limits(const VectorX& x) const override {
    return model_->convex_limits(x);
  }
  Objective objective_at_geometry(const VectorX& x, const std::vector<int>& free,
                                  const dynamics::FreeSprings& loose) const override {
    return model_->objective_at_geometry(x, free, loose);
  }
  std::vector<DesignLimit> limits_at_geometry(const VectorX& x, const std::vector<int>& free,
                                              const dynamics::FreeSprings& loose) const override {
    return model_->limits_at_geometry(x, free, loose);
  }

 protected:
  const DesignModel& model() const { return *model_; }

 private:
  std::shared_ptr<const DesignModel> model_;
};

}  // namespace balance::design
