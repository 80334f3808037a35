#include "balance/design/nlopt_search.hpp"

#include <nlopt.h>

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
constexpr std::array local_methods = {
    Method{"slsqp", NLOPT_LD_SLSQP},   Method{"auglag", NLOPT_AUGLAG},  Method{"cobyla", NLOPT_LN_COBYLA},
    Method{"bobyqa", NLOPT_LN_BOBYQA}, Method{"sbplx", NLOPT_LN_SBPLX},
};
constexpr std::array global_methods = {
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

/// Carries the program through NLopt's C interface: exceptions are kept and thrown again on the other side, the best
/// admissible point is remembered whatever status the search ends with.
class Run {
 public:
  Run(const Program& program, nlopt_algorithm algorithm, const SearchLimits& limits)
      : program_(program), optimiser_(create(program, algorithm)) {
    nlopt_set_min_objective(optimiser_.get(), &Run::objective, this);
    nlopt_set_maxeval(optimiser_.get(), limits.evaluations);
    if (limits.seconds > 0) nlopt_set_maxtime(optimiser_.get(), limits.seconds);
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

  void add_constraints(bool equalities) {
    // tolerances of NLopt's own; the caller polishes what is found
    const std::vector<double> equal(static_cast<std::size_t>(program_.equality_count), 1e-12);
    const std::vector<double> unequal(static_cast<std::size_t>(program_.inequality_count), 1e-10);
    if (equalities && !equal.empty())
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
    Found found{start.cwiseMax(-program_.bound).cwiseMin(program_.bound), 0, {}};
    const nlopt_result status = nlopt_optimize(get(), found.u.data(), &found.value);
    if (trouble_) std::rethrow_exception(trouble_);
    found.status = nlopt_result_to_string(status);
    // negative codes other than ROUNDOFF_LIMITED leave u as it was last: still a point of the box
    if (!found.u.allFinite()) found.u = start;
    found.u = found.u.cwiseMax(-program_.bound).cwiseMin(program_.bound);
    found.value = program_.objective(found.u, nullptr);
    return found;
  }

 private:
  template <class Work>
  void guarded(const Work& work) noexcept {
    try {
      work();
    } catch (...) {
      if (!trouble_) trouble_ = std::current_exception();
      nlopt_force_stop(get());
    }
  }

  static double objective(unsigned n, const double* u, double* gradient, void* self) {
    Run& run = *static_cast<Run*>(self);
    double value = HUGE_VAL;
    run.guarded([&] {
      VectorX slope;
      value = run.program_.objective(Eigen::Map<const VectorX>(u, n), gradient != nullptr ? &slope : nullptr);
      if (gradient != nullptr) Eigen::Map<VectorX>(gradient, n) = slope;
    });
    return std::isfinite(value) ? value : HUGE_VAL;
  }

  static void constraints(const std::function<void(const VectorX&, VectorX&, MatrixX*)>& f, double sign, Run& run,
                          unsigned m, double* result, unsigned n, const double* u, double* gradient) {
    run.guarded([&] {
      VectorX values;
      MatrixX jacobian;
      f(Eigen::Map<const VectorX>(u, n), values, gradient != nullptr ? &jacobian : nullptr);
      Eigen::Map<VectorX>(result, m) = sign * values;
      if (gradient != nullptr) Eigen::Map<Samples>(gradient, m, n) = sign * jacobian;
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
  Optimiser optimiser_;
  std::exception_ptr trouble_;
};

}  // namespace

bool is_local_method(const std::string& name) { return name == "auto" || find(local_methods, name) != nullptr; }
bool is_global_method(const std::string& name) { return find(global_methods, name) != nullptr; }
bool wants_gradients(const std::string& local_method) { return local_method == "slsqp" || local_method == "auglag"; }

Found search_locally(const std::string& method, const Program& program, const VectorX& start,
                     const SearchLimits& limits) {
  // BOBYQA's quadratic model needs two dimensions
  const Method* found = find(local_methods, method == "bobyqa" && program.size == 1 ? "sbplx" : method);
  if (found == nullptr) throw std::invalid_argument("no local search is called " + method);
  Run run(program, found->algorithm, limits);
  if (method != "bobyqa" && method != "sbplx") run.add_constraints(true);
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
  const Method* found = find(global_methods, method);
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
