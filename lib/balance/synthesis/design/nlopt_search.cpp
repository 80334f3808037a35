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

/// Carries the program through NLopt's C interface: exceptions are kept and thrown again on the other side, points that are
/// not finite never reach the program (some methods make them when they run out of digits), the best point of a search
/// without constraints is remembered whatever status it ends with.
class NloptSearch {
 public:
  NloptSearch(const NonlinearProgram& program, nlopt_algorithm algorithm, const StoppingCriteria& limits)
      : program_(program), limits_(limits), begin_(thread_cpu_time()), optimiser_(create(program, algorithm)) {
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
    // tolerances of NLopt's own; the caller polishes what is found
    const std::vector<double> equal(static_cast<std::size_t>(program_.equality_count), 1e-12);
    const std::vector<double> unequal(static_cast<std::size_t>(program_.inequality_count), 1e-10);
    constrained_ = !equal.empty() || !unequal.empty();
    if (!equal.empty())
      nlopt_add_equality_mconstraint(get(), static_cast<unsigned>(equal.size()), &NloptSearch::equalities, this,
                                     equal.data());
    if (!unequal.empty())
      nlopt_add_inequality_mconstraint(get(), static_cast<unsigned>(unequal.size()), &NloptSearch::inequalities, this,
                                       unequal.data());
  }

  void stop_at_changes_below(double relative) {
    nlopt_set_xtol_rel(get(), relative);
    nlopt_set_ftol_rel(get(), relative);
  }

  NloptResult optimise(const VectorX& start) {
    NloptResult found{start.cwiseMax(-program_.bound).cwiseMin(program_.bound)};
    const VectorX from = found.u;
    const nlopt_result status = nlopt_optimize(get(), found.u.data(), &found.value);
    if (trouble_) std::rethrow_exception(trouble_);
    found.is_budget_exhausted = out_of_time_ || status == NLOPT_MAXEVAL_REACHED;
    // negative codes leave u as it was last, which may be worse than what was met on the way
    if (!constrained_ && best_.size() > 0) found.u = best_;
    if (!found.u.allFinite()) found.u = from;
    found.u = found.u.cwiseMax(-program_.bound).cwiseMin(program_.bound);
    found.value = !constrained_ && best_.size() > 0 ? least_ : program_.objective(found.u, nullptr);
    return found;
  }

 private:
  template <class Work>
  void run_guarded(const Work& work) noexcept {
    try {
      const bool late = limits_.max_time > 0 && thread_cpu_time() - begin_ > limits_.max_time;
      if (late || (limits_.stop && limits_.stop())) {
        out_of_time_ = true;
        nlopt_force_stop(get());
      }
      work();
    } catch (const DeadlineExceeded&) {
      out_of_time_ = true;
      nlopt_force_stop(get());
    } catch (...) {
      if (!trouble_) trouble_ = std::current_exception();
      nlopt_force_stop(get());
    }
  }

  /// A number in place of none: worse than all that was met, yet not so large that a method's models drown in it.
  double undefined_value() const { return highest_ + std::abs(highest_) + 1; }

  double value_at(const VectorX& u, VectorX* slope) {
    if (!u.allFinite()) return undefined_value();
    const double value = program_.objective(u, slope);
    if (!std::isfinite(value)) return undefined_value();
    highest_ = std::max(highest_, value);
    if (best_.size() == 0 || value < least_) {
      best_ = u;
      least_ = value;
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
      VectorX values = VectorX::Constant(m, -sign);  // not met
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
  double begin_;
  NloptHandle optimiser_;
  bool constrained_ = false, out_of_time_ = false;
  VectorX best_;
  double least_ = 0, highest_ = 0;
  std::exception_ptr trouble_;
};

}  // namespace

bool is_gradient_based(const std::string& local_method) { return local_method == "slsqp" || local_method == "auglag"; }

NloptResult search_locally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                           const StoppingCriteria& limits) {
  // BOBYQA's quadratic model needs two dimensions
  const NloptMethod* found = find_method(local_methods, method == "bobyqa" && program.size == 1 ? "sbplx" : method);
  if (found == nullptr) throw std::invalid_argument("no local search is called " + method);
  NloptSearch run(program, found->algorithm, limits);
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
  const NloptMethod* found = find_method(global_methods, method);
  if (found == nullptr) throw std::invalid_argument("no global search is called " + method);
  nlopt_srand(static_cast<unsigned long>(seed));
  NloptSearch run(program, found->algorithm, limits);
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
