#include "balance/mechanics/model/couplings.hpp"

#include "balance/foundation/numerics/engine_scalar.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::model {

namespace {

template <class T>
class CouplingResolver {
 public:
  explicit CouplingResolver(const MechanismOf<T>& mechanism)
      : coupling_of_(mechanism.coordinates.size(), nullptr),
        state_(mechanism.coordinates.size(), State::unknown),
        roots_(mechanism.coordinates.size()) {
    for (const CouplingOf<T>& coupling : mechanism.couplings)
      if (coupling_of_[coupling.follower] == nullptr) coupling_of_[coupling.follower] = &coupling;
  }

  std::vector<ResolvedCouplingOf<T>> run() {
    for (int c = 0; c < static_cast<int>(roots_.size()); ++c) resolve(c);
    return std::move(roots_);
  }

 private:
  enum class State { unknown, open, known };

  /// Resolves leaders before their followers. Iterative, because chains may be long.
  void resolve(CoordinateId coordinate) {
    std::vector<int> pending = {coordinate};
    while (!pending.empty()) {
      const int c = pending.back();
      const CouplingOf<T>* coupling = coupling_of_[c];
      if (state_[c] == State::unknown && coupling != nullptr) {
        state_[c] = State::open;
        for (const CoordinateTermOf<T>& term : coupling->leader.terms) {
          if (state_[term.coordinate] == State::open) throw std::invalid_argument("couplings form a cycle");
          if (state_[term.coordinate] == State::unknown) pending.push_back(term.coordinate);
        }
        continue;
      }
      if (state_[c] != State::known)
        roots_[c] = coupling == nullptr ? ResolvedCouplingOf<T>{{{c, T(1)}}} : sum(*coupling);
      state_[c] = State::known;
      pending.pop_back();
    }
  }

  ResolvedCouplingOf<T> sum(const CouplingOf<T>& coupling) const {
    ResolvedCouplingOf<T> out{{}, coupling.offset};
    for (const CoordinateTermOf<T>& leader : coupling.leader.terms) {
      const ResolvedCouplingOf<T>& resolved = roots_[leader.coordinate];
      const T ratio = coupling.ratio * leader.ratio;
      out.offset += ratio * resolved.offset;
      for (const CoordinateTermOf<T>& root : resolved.terms) {
        const auto existing = std::find_if(out.terms.begin(), out.terms.end(), [&](const CoordinateTermOf<T>& term) {
          return term.coordinate == root.coordinate;
        });
        if (existing == out.terms.end())
          out.terms.push_back({root.coordinate, ratio * root.ratio});
        else
          existing->ratio += ratio * root.ratio;
      }
    }
    return out;
  }

  std::vector<const CouplingOf<T>*> coupling_of_;
  std::vector<State> state_;
  std::vector<ResolvedCouplingOf<T>> roots_;
};

}  // namespace

template <class T>
std::vector<ResolvedCouplingOf<T>> resolve_couplings(const MechanismOf<T>& mechanism) {
  return CouplingResolver<T>(mechanism).run();
}

template std::vector<ResolvedCouplingOf<EngineScalar>> resolve_couplings<EngineScalar>(
    const MechanismOf<EngineScalar>&);

}  // namespace balance::model
