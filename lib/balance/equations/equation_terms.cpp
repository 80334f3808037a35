#include "balance/equations/equation_terms.hpp"

#include "balance/equations/engine.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

std::unique_ptr<EquationTerms::Implementation> make_equation_terms(const Mechanism& mechanism,
                                                                   const InverseOptions& options) {
  require_valid(mechanism);
  if (!(options.time_scale > 0) || !std::isfinite(options.time_scale))
    throw std::invalid_argument("time_scale: expected a positive number");
  return dispatch_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<EquationTerms::Implementation> {
    return std::make_unique<EquationTermsOf<S>>(mechanism, options);
  });
}

void check_vector(const char* what, const VectorX& values, const std::vector<CoordinateId>& independent) {
  if (values.size() != static_cast<Eigen::Index>(independent.size()))
    throw std::invalid_argument(std::string(what) + ": expected " + std::to_string(independent.size()) +
                                " numbers; got " + std::to_string(values.size()));
  if (!values.allFinite()) throw std::invalid_argument(std::string(what) + ": expected finite numbers");
}

}  // namespace

EquationTerms::EquationTerms(const Mechanism& mechanism, const InverseOptions& options)
    : engine_(make_equation_terms(mechanism, options)) {}
EquationTerms::~EquationTerms() = default;
EquationTerms::EquationTerms(EquationTerms&&) noexcept = default;
EquationTerms& EquationTerms::operator=(EquationTerms&&) noexcept = default;

const Mechanism& EquationTerms::mechanism() const { return engine_->mechanism; }
int EquationTerms::degrees_of_freedom() const { return static_cast<int>(engine_->independent.size()); }
const std::vector<CoordinateId>& EquationTerms::independent() const { return engine_->independent; }
const std::vector<std::string>& EquationTerms::redundant() const { return engine_->redundant; }
std::vector<bool> EquationTerms::redundant_lengths() const { return engine_->redundant_lengths; }
const std::vector<std::string>& EquationTerms::closures() const { return engine_->closures; }
const std::vector<std::string>& EquationTerms::notes() const { return engine_->notes; }

Expected<VectorX> EquationTerms::assemble(const VectorX& q, const std::vector<CoordinateValue>& near) {
  check_vector("q", q, engine_->independent);
  Expected<VectorX> found;
  found.outcome = engine_->assemble(q.data(), near, found.value);
  return found;
}

Expected<IndependentTerms> EquationTerms::independent_terms(const VectorX& q, double time) {
  check_vector("q", q, engine_->independent);
  Expected<IndependentTerms> found;
  found.outcome = engine_->independent_terms(q.data(), time, found.value);
  return found;
}

Expected<RedundantTerms> EquationTerms::redundant_terms(const VectorX& q, double time) {
  check_vector("q", q, engine_->independent);
  Expected<RedundantTerms> found;
  found.outcome = engine_->redundant_terms(q.data(), time, found.value);
  return found;
}

Expected<EffortBreakdown> EquationTerms::split_efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq,
                                                       double time) {
  check_vector("q", q, engine_->independent);
  check_vector("dq", dq, engine_->independent);
  check_vector("ddq", ddq, engine_->independent);
  Expected<EffortBreakdown> found;
  found.outcome = engine_->split(q.data(), dq.data(), ddq.data(), time, found.value);
  return found;
}

}  // namespace balance
