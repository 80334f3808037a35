#include "balance/design/nlopt_search.hpp"

#include "balance/base/computing_time.hpp"

#include <nlopt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace balance::designing {

namespace {

struct Method {
  std::string_view name;
  nlopt_algorithm algorithm;
};
constexpr std::array local_searches = {
    Method{"slsqp", NLOPT_LD_SLSQP},   Method{"auglag", NLOPT_AUGLAG},  Method{"cobyla", NLOPT_LN_COBYLA},
    Method{"bobyqa", NLOPT_LN_BOBYQA}, Method{"sbplx", NLOPT_LN_SBPLX},
};
constexpr std::array global_searches = {
    Method{"direct", NLOPT_GN_DIRECT_L}, Method{"crs", NLOPT_GN_CRS2_LM},  Method{"isres", NLOPT_GN_ISRES},
    Method{"esch", NLOPT_GN_ESCH},       Method{"mlsl", NLOPT_G_MLSL_LDS},
};

template <class Methods>
const Method* find(const Methods& methods, std::string_view name) {
  for (const Method& method : methods)
    if (method.name == name) return &method;
  return nullptr;
}

struct Destroy {
  void operator()(nlopt_opt_s* opt) const { nlopt_destroy(opt); }
};
using Optimiser = std::unique_ptr<nlopt_opt_s, Destroy>;

/// Carries the program through NLopt's C interface: exceptions are kept and thrown again on the other side, points that are
/// not finite never reach the program (some methods make them when they run out of digits), the best point of a search
/// without constraints is remembered whatever status it ends with.
class Run {
 public:
  Run(const Program& program, nlopt_algorithm algorithm, const SearchLimits& limits)
      : program_(program), limits_(limits), begin_(computing_time()), optimiser_(create(program, algorithm)) {
    nlopt_set_min_objective(optimiser_.get(), &Run::objective, this);
    nlopt_set_maxeval(optimiser_.get(), limits.evaluations);
  }
  Run(const Run&) = delete;

  static Optimiser create(const Program& program, nlopt_algorithm algorithm) {
    Optimiser optimiser(nlopt_create(algorithm, static_cast<unsigned>(program.size)));
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
      nlopt_add_equality_mconstraint(get(), static_cast<unsigned>(equal.size()), &Run::equalities, this, equal.data());
    if (!unequal.empty())
      nlopt_add_inequality_mconstraint(get(), static_cast<unsigned>(unequal.size()), &Run::inequalities, this,
                                       unequal.data());
  }

  void stop_at_changes_below(double relative) {
    nlopt_set_xtol_rel(get(), relative);
    nlopt_set_ftol_rel(get(), relative);
  }

  Found optimise(const VectorX& start) {
    Found found{start.cwiseMax(-program_.bound).cwiseMin(program_.bound)};
    const VectorX from = found.u;
    const nlopt_result status = nlopt_optimize(get(), found.u.data(), &found.value);
    if (trouble_) std::rethrow_exception(trouble_);
    found.stopped = out_of_time_ || status == NLOPT_MAXEVAL_REACHED;
    // negative codes leave u as it was last, which may be worse than what was met on the way
    if (!constrained_ && best_.size() > 0) found.u = best_;
    if (!found.u.allFinite()) found.u = from;
    found.u = found.u.cwiseMax(-program_.bound).cwiseMin(program_.bound);
    found.value = !constrained_ && best_.size() > 0 ? least_ : program_.objective(found.u, nullptr);
    return found;
  }

 private:
  template <class Work>
  void guarded(const Work& work) noexcept {
    try {
      const bool late = limits_.seconds > 0 && computing_time() - begin_ > limits_.seconds;
      if (late || (limits_.stop && limits_.stop())) {
        out_of_time_ = true;
        nlopt_force_stop(get());
      }
      work();
    } catch (const OutOfTime&) {
      out_of_time_ = true;
      nlopt_force_stop(get());
    } catch (...) {
      if (!trouble_) trouble_ = std::current_exception();
      nlopt_force_stop(get());
    }
  }

  /// A number in place of none: worse than all that was met, yet not so large that a method's models drown in it.
  double none() const { return highest_ + std::abs(highest_) + 1; }

  double value_at(const VectorX& u, VectorX* slope) {
    if (!u.allFinite()) return none();
    const double value = program_.objective(u, slope);
    if (!std::isfinite(value)) return none();
    highest_ = std::max(highest_, value);
    if (best_.size() == 0 || value < least_) {
      best_ = u;
      least_ = value;
    }
    return value;
  }

  static double objective(unsigned n, const double* u, double* gradient, void* self) {
    Run& run = *static_cast<Run*>(self);
    double value = HUGE_VAL;
    run.guarded([&] {
      VectorX slope = VectorX::Zero(n);
      value = run.value_at(Eigen::Map<const VectorX>(u, n), gradient != nullptr ? &slope : nullptr);
      if (gradient != nullptr) Eigen::Map<VectorX>(gradient, n) = slope.allFinite() ? slope : VectorX(VectorX::Zero(n));
    });
    return value;
  }

  static void constraints(const std::function<void(const VectorX&, VectorX&, MatrixX*)>& f, double sign, Run& run,
                          unsigned m, double* result, unsigned n, const double* u, double* gradient) {
    run.guarded([&] {
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
    Run& run = *static_cast<Run*>(self);
    constraints(run.program_.equalities, 1, run, m, result, n, u, gradient);
  }
  static void inequalities(unsigned m, double* result, unsigned n, const double* u, double* gradient, void* self) {
    Run& run = *static_cast<Run*>(self);
    constraints(run.program_.inequalities, -1, run, m, result, n, u, gradient);
  }

  const Program& program_;
  SearchLimits limits_;
  double begin_;
  Optimiser optimiser_;
  bool constrained_ = false, out_of_time_ = false;
  VectorX best_;
  double least_ = 0, highest_ = 0;
  std::exception_ptr trouble_;
};

}  // namespace

bool wants_gradients(const std::string& local_method) { return local_method == "slsqp" || local_method == "auglag"; }

Found search_locally(const std::string& method, const Program& program, const VectorX& start,
                     const SearchLimits& limits) {
  // BOBYQA's quadratic model needs two dimensions
  const Method* found = find(local_searches, method == "bobyqa" && program.size == 1 ? "sbplx" : method);
  if (found == nullptr) throw std::invalid_argument("no local search is called " + method);
  Run run(program, found->algorithm, limits);
  if (method != "bobyqa" && method != "sbplx") run.add_constraints();
  run.stop_at_changes_below(limits.relative);
  if (limits.step > 0) nlopt_set_initial_step1(run.get(), limits.step);
  Optimiser inner;
  if (method == "auglag") {
    inner = Run::create(program, NLOPT_LD_LBFGS);
    nlopt_set_ftol_rel(inner.get(), 1e-10);
    nlopt_set_maxeval(inner.get(), 200);
    nlopt_set_local_optimizer(run.get(), inner.get());
  }
  return run.optimise(start);
}

Found search_globally(const std::string& method, const Program& program, const VectorX& start,
                      const SearchLimits& limits, std::uint64_t seed, bool gradients) {
  const Method* found = find(global_searches, method);
  if (found == nullptr) throw std::invalid_argument("no global search is called " + method);
  nlopt_srand(static_cast<unsigned long>(seed));
  Run run(program, found->algorithm, limits);
  Optimiser inner;
  if (method == "mlsl") {
    inner = Run::create(program, gradients ? NLOPT_LD_SLSQP : NLOPT_LN_BOBYQA);
    nlopt_set_ftol_rel(inner.get(), 1e-8);
    nlopt_set_xtol_rel(inner.get(), 1e-6);
    nlopt_set_local_optimizer(run.get(), inner.get());
  }
  return run.optimise(start);
}

}  // namespace balance::designing
