#include "balance/equations/equation_terms.hpp"

#include "balance/equations/engine.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

std::unique_ptr<EquationTerms::Engine> make_engine(const Mechanism& mechanism, const InverseOptions& options) {
  require_valid(mechanism);
  if (!(options.time_scale > 0) || !std::isfinite(options.time_scale))
    throw std::invalid_argument("time_scale: expected a positive number");
  return in_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<EquationTerms::Engine> {
    return std::make_unique<TermsEngine<S>>(mechanism, options);
  });
}

void check(const char* what, const VectorX& values, const std::vector<CoordinateId>& independent) {
  if (values.size() != static_cast<Eigen::Index>(independent.size()))
    throw std::invalid_argument(std::string(what) + ": expected " + std::to_string(independent.size()) +
                                " numbers; got " + std::to_string(values.size()));
  if (!values.allFinite()) throw std::invalid_argument(std::string(what) + ": expected finite numbers");
}

}  // namespace

EquationTerms::EquationTerms(const Mechanism& mechanism, const InverseOptions& options)
    : engine_(make_engine(mechanism, options)) {}
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

Answer<VectorX> EquationTerms::assemble(const VectorX& q, const std::vector<CoordinateValue>& near) {
  check("q", q, engine_->independent);
  Answer<VectorX> found;
  found.outcome = engine_->assemble(q.data(), near, found.value);
  return found;
}

Answer<IndependentTerms> EquationTerms::independent_terms(const VectorX& q, double time) {
  check("q", q, engine_->independent);
  Answer<IndependentTerms> found;
  found.outcome = engine_->independent_terms(q.data(), time, found.value);
  return found;
}

Answer<RedundantTerms> EquationTerms::redundant_terms(const VectorX& q, double time) {
  check("q", q, engine_->independent);
  Answer<RedundantTerms> found;
  found.outcome = engine_->redundant_terms(q.data(), time, found.value);
  return found;
}

Answer<EffortSplit> EquationTerms::split(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time) {
  check("q", q, engine_->independent);
  check("dq", dq, engine_->independent);
  check("ddq", ddq, engine_->independent);
  Answer<EffortSplit> found;
  found.outcome = engine_->split(q.data(), dq.data(), ddq.data(), time, found.value);
  return found;
}

}  // namespace balance
