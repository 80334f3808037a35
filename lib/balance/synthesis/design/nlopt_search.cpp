#include "balance/synthesis/design/nlopt_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"

#include <nlopt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace balance::design {

namespace {

struct NloptMethod {
  std::string_view name;
  nlopt_algorithm algorithm;
};
constexpr std::array local_methods = {
    NloptMethod{"slsqp", NLOPT_LD_SLSQP},   NloptMethod{"auglag", NLOPT_AUGLAG},
    NloptMethod{"cobyla", NLOPT_LN_COBYLA}, NloptMethod{"bobyqa", NLOPT_LN_BOBYQA},
    NloptMethod{"sbplx", NLOPT_LN_SBPLX},
};
constexpr std::array global_methods = {
    NloptMethod{"direct", NLOPT_GN_DIRECT_L}, NloptMethod{"crs", NLOPT_GN_CRS2_LM},
    NloptMethod{"isres", NLOPT_GN_ISRES},     NloptMethod{"esch", NLOPT_GN_ESCH},
    NloptMethod{"mlsl", NLOPT_G_MLSL_LDS},
};

template <class Methods>
const NloptMethod* find_method(const Methods& methods, std::string_view name) {
  for (const NloptMethod& method : methods)
    if (method.name == name) return &method;
  return nullptr;
}

struct NloptDeleter {
  void operator()(nlopt_opt_s* opt) const { nlopt_destroy(opt); }
};
using NloptHandle = std::unique_ptr<nlopt_opt_s, NloptDeleter>;

/// Adapter to the C interface of NLopt. Exceptions are stored and rethrown after the search. Non-finite points, which
/// some methods produce when they run out of precision, never reach the program. For searches without constraints the
/// best point is recorded, whatever the status of the search.
class NloptSearch {
 public:
  NloptSearch(const NonlinearProgram& program, nlopt_algorithm algorithm, const StoppingCriteria& limits)
      : program_(program), limits_(limits), start_time_(thread_cpu_time()), optimiser_(create(program, algorithm)) {
    nlopt_set_min_objective(optimiser_.get(), &NloptSearch::objective, this);
    nlopt_set_maxeval(optimiser_.get(), limits.max_evaluations);
  }
  NloptSearch(const NloptSearch&) = delete;

  static NloptHandle create(const NonlinearProgram& program, nlopt_algorithm algorithm) {
    NloptHandle optimiser(nlopt_create(algorithm, static_cast<unsigned>(program.size)));
    if (!optimiser) throw std::bad_alloc();
    nlopt_set_lower_bounds1(optimiser.get(), -program.bound);
    nlopt_set_upper_bounds1(optimiser.get(), program.bound);
    return optimiser;
  }

  nlopt_opt get() const { return optimiser_.get(); }

  void add_constraints() {
    // tolerances within NLopt; the caller refines the result
    const std::vector<double> equality_tolerances(static_cast<std::size_t>(program_.equality_count), 1e-12);
    const std::vector<double> inequality_tolerances(static_cast<std::size_t>(program_.inequality_count), 1e-10);
    has_constraints_ = !equality_tolerances.empty() || !inequality_tolerances.empty();
    if (!equality_tolerances.empty())
      nlopt_add_equality_mconstraint(get(), static_cast<unsigned>(equality_tolerances.size()), &NloptSearch::equalities,
                                     this, equality_tolerances.data());
    if (!inequality_tolerances.empty())
      nlopt_add_inequality_mconstraint(get(), static_cast<unsigned>(inequality_tolerances.size()),
                                       &NloptSearch::inequalities, this, inequality_tolerances.data());
  }

  void stop_at_changes_below(double relative) {
    nlopt_set_xtol_rel(get(), relative);
    nlopt_set_ftol_rel(get(), relative);
  }

  NloptResult optimise(const VectorX& start) {
    NloptResult result{start.cwiseMax(-program_.bound).cwiseMin(program_.bound)};
    const VectorX from = result.u;
    const nlopt_result status = nlopt_optimize(get(), result.u.data(), &result.value);
    if (exception_) std::rethrow_exception(exception_);
    result.is_budget_exhausted = is_budget_exhausted_ || status == NLOPT_MAXEVAL_REACHED;
    // After an error code, u is the last point, which may be worse than the best one.
    if (!has_constraints_ && best_.size() > 0) result.u = best_;
    if (!result.u.allFinite()) result.u = from;
    result.u = result.u.cwiseMax(-program_.bound).cwiseMin(program_.bound);
    result.value = !has_constraints_ && best_.size() > 0 ? best_value_ : program_.objective(result.u, nullptr);
    return result;
  }

 private:
  template <class Work>
  void run_guarded(const Work& work) noexcept {
    try {
      const bool is_late = limits_.max_time > 0 && thread_cpu_time() - start_time_ > limits_.max_time;
      if (is_late || (limits_.stop && limits_.stop())) {
        is_budget_exhausted_ = true;
        nlopt_force_stop(get());
      }
      work();
    } catch (const DeadlineExceeded&) {
      is_budget_exhausted_ = true;
      nlopt_force_stop(get());
    } catch (...) {
      if (!exception_) exception_ = std::current_exception();
      nlopt_force_stop(get());
    }
  }

  /// Finite substitute for undefined values: worse than all previous values, but not so large that it spoils the models
  /// of a method.
  double undefined_value() const { return max_value_ + std::abs(max_value_) + 1; }

  double value_at(const VectorX& u, VectorX* slope) {
    if (!u.allFinite()) return undefined_value();
    const double value = program_.objective(u, slope);
    if (!std::isfinite(value)) return undefined_value();
    max_value_ = std::max(max_value_, value);
    if (best_.size() == 0 || value < best_value_) {
      best_ = u;
      best_value_ = value;
    }
    return value;
  }

  static double objective(unsigned n, const double* u, double* gradient, void* self) {
    NloptSearch& run = *static_cast<NloptSearch*>(self);
    double value = HUGE_VAL;
    run.run_guarded([&] {
      VectorX slope = VectorX::Zero(n);
      value = run.value_at(Eigen::Map<const VectorX>(u, n), gradient != nullptr ? &slope : nullptr);
      if (gradient != nullptr) Eigen::Map<VectorX>(gradient, n) = slope.allFinite() ? slope : VectorX(VectorX::Zero(n));
    });
    return value;
  }

  static void constraints(const std::function<void(const VectorX&, VectorX&, MatrixX*)>& f, double sign,
                          NloptSearch& run, unsigned m, double* result, unsigned n, const double* u, double* gradient) {
    run.run_guarded([&] {
      VectorX values = VectorX::Constant(m, -sign);  // violated
      MatrixX jacobian = MatrixX::Zero(m, n);
      if (const VectorX at = Eigen::Map<const VectorX>(u, n); at.allFinite())
        f(at, values, gradient != nullptr ? &jacobian : nullptr);
      Eigen::Map<VectorX>(result, m) = values.allFinite() ? VectorX(sign * values) : VectorX(VectorX::Ones(m));
      if (gradient != nullptr)
        Eigen::Map<Samples>(gradient, m, n) =
            jacobian.allFinite() ? MatrixX(sign * jacobian) : MatrixX(MatrixX::Zero(m, n));
    });
  }
  static void equalities(unsigned m, double* result, unsigned n, const double* u, double* gradient, void* self) {
    NloptSearch& run = *static_cast<NloptSearch*>(self);
    constraints(run.program_.equalities, 1, run, m, result, n, u, gradient);
  }
  static void inequalities(unsigned m, double* result, unsigned n, const double* u, double* gradient, void* self) {
    NloptSearch& run = *static_cast<NloptSearch*>(self);
    constraints(run.program_.inequalities, -1, run, m, result, n, u, gradient);
  }

  const NonlinearProgram& program_;
  StoppingCriteria limits_;
  double start_time_;
  NloptHandle optimiser_;
  bool has_constraints_ = false, is_budget_exhausted_ = false;
  VectorX best_;
  double best_value_ = 0, max_value_ = 0;
  std::exception_ptr exception_;
};

}  // namespace

bool is_gradient_based(const std::string& local_method) { return local_method == "slsqp" || local_method == "auglag"; }

NloptResult search_locally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                           const StoppingCriteria& limits) {
  // BOBYQA requires at least two dimensions.
  const NloptMethod* nlopt_method =
      find_method(local_methods, method == "bobyqa" && program.size == 1 ? "sbplx" : method);
  if (nlopt_method == nullptr) throw std::invalid_argument("there is no local search " + method);
  NloptSearch run(program, nlopt_method->algorithm, limits);
  if (method != "bobyqa" && method != "sbplx") run.add_constraints();
  run.stop_at_changes_below(limits.relative_tolerance);
  if (limits.initial_step > 0) nlopt_set_initial_step1(run.get(), limits.initial_step);
  NloptHandle inner;
  if (method == "auglag") {
    inner = NloptSearch::create(program, NLOPT_LD_LBFGS);
    nlopt_set_ftol_rel(inner.get(), 1e-10);
    nlopt_set_maxeval(inner.get(), 200);
    nlopt_set_local_optimizer(run.get(), inner.get());
  }
  return run.optimise(start);
}

NloptResult search_globally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                            const StoppingCriteria& limits, std::uint64_t seed, bool gradients) {
  const NloptMethod* nlopt_method = find_method(global_methods, method);
  if (nlopt_method == nullptr) throw std::invalid_argument("there is no global search " + method);
  nlopt_srand(static_cast<unsigned long>(seed));
  NloptSearch run(program, nlopt_method->algorithm, limits);
  NloptHandle inner;
  if (method == "mlsl") {
    inner = NloptSearch::create(program, gradients ? NLOPT_LD_SLSQP : NLOPT_LN_BOBYQA);
    nlopt_set_ftol_rel(inner.get(), 1e-8);
    nlopt_set_xtol_rel(inner.get(), 1e-6);
    nlopt_set_local_optimizer(run.get(), inner.get());
  }
  return run.optimise(start);
}

}  // namespace balance::design
