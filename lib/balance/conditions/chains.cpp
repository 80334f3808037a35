#include "balance/conditions/chains.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/conditions/chain_builder.hpp"
#include "balance/conditions/cuts.hpp"
#include "balance/conditions/known_terms.hpp"
#include "balance/conditions/text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {

namespace {

using Eigen::Index;

class ChainSplitter {
 public:
  ChainSplitter(const Mechanism& whole, const FreeSprings& loose)
      : whole_(whole),
        loose_(loose),
        d_(whole.space == SpaceKind::planar ? 2 : 3),
        parameters_(list_terms(whole, loose)),
        columns_(parameters_),
        cuts_(partition_graph(whole)),
        tips_(static_cast<std::size_t>(cuts_.chains)) {}

  ChainSplit run() {
    split_.failure_reason = cuts_.failure_reason;
    split_.is_serial = cuts_.platforms.empty() && cuts_.opened_joints.empty();
    if (!split_.failure_reason.empty() || split_.is_serial) return std::move(split_);
    split_.unassigned = MatrixX::Identity(columns_.count(), columns_.count());
    for (const Platform& platform : cuts_.platforms) distribute_platform_mass(platform);
    for (const JointId joint : cuts_.opened_joints) open_loop(joint);
    for (int chain = 0; chain < cuts_.chains; ++chain) build(chain);
    describe();
    return std::move(split_);
  }

 private:
  const Joint& joint(int j) const { return whole_.joints[static_cast<std::size_t>(j)]; }
  int chain_of(BodyId body) const { return cuts_.chain_of[static_cast<std::size_t>(body)]; }

  void add_tip(int j, int other, const VectorX& mass) {
    const int own = joint(j).first == other ? joint(j).second : joint(j).first;
    tips_[static_cast<std::size_t>(chain_of(own))].push_back({j, other, mass});
  }

  /// Mass and first moments of a body with everything on it, linear in the parameters: (1 + d) × P.
  MatrixX moments(BodyId body) const {
    MatrixX sum = MatrixX::Zero(1 + d_, columns_.count());
    const auto add = [&](ParameterOwner bearer, std::size_t index) {
      const Index first = columns_.first(bearer, static_cast<int>(index));
      sum.middleCols(first, 1 + d_) += MatrixX::Identity(1 + d_, 1 + d_);
    };
    add(ParameterOwner::body, static_cast<std::size_t>(body));
    for (std::size_t a = 0; a < whole_.attachments.size(); ++a)
      if (whole_.attachments[a].body == body) add(ParameterOwner::attachment, a);
    for (std::size_t k = 0; k < whole_.discs.size(); ++k)
      if (whole_.discs[k].body == body) {
        const Index mass = columns_.first(ParameterOwner::disc, static_cast<int>(k));
        sum(0, mass) += 1;
        sum.col(mass).tail(d_) += whole_.discs[k].position.head(d_);
      }
    return sum;
  }

  /// Equal masses at the joints and smallest additions that move the CoM: wᵢ = m / n + dᵢᵀ (Σ d dᵀ)⁺ (m r − m r̄), with d the
  /// joints' places from their mean r̄.
  void distribute_platform_mass(const Platform& platform) {
    const auto n = static_cast<Index>(platform.joints.size());
    MatrixX places(d_, n);
    for (Index i = 0; i < n; ++i) {
      const Joint& at = joint(platform.joints[static_cast<std::size_t>(i)]);
      places.col(i) = (at.first == platform.body ? at.point_first : at.point_second).head(d_);
    }
    const VectorX mean = places.rowwise().mean();
    const MatrixX total = moments(platform.body);
    CompleteOrthogonalDecomposition solver;
    solver.setThreshold(coincidence_tolerance);
    solver.compute(places.colwise() - mean);
    MatrixX shares = solver.solve(total.bottomRows(d_) - mean * total.row(0));
    shares.rowwise() += total.row(0) / static_cast<double>(n);
    std::string text;
    const Index own = columns_.first(ParameterOwner::body, platform.body),
                size = columns_.size(ParameterOwner::body, platform.body);
    for (Index i = 0; i < n; ++i) {
      Vector3 place = Vector3::Zero();
      place.head(d_) = places.col(i);
      const VectorX mass = shares.row(i).transpose();
      split_.unassigned.middleRows(own, size) -= point_mass_parameters(whole_.space, place) * mass.transpose();
      const int at = platform.joints[static_cast<std::size_t>(i)];
      add_tip(at, platform.body, mass);
      text += (text.empty() ? "" : "; ") + ("at " + joint(at).name + ": " + linear_combination_text(parameters_, mass));
    }
    split_.notes.push_back("the chains carry point masses " + text);
    // Cancelled to round-off.
    for (double& entry : split_.unassigned.reshaped())
      if (std::abs(entry) < 1e-14 * std::max(1.0, max_abs(places))) entry = 0;
    if (solver.rank() < d_)
      split_.notes.push_back(
          fmt::format("the joints of {} lie on one {}: point masses there reproduce its CoM only as far as it "
                      "lies on it too",
                      name(platform.body), solver.rank() == 2 ? "plane" : "line"));
  }

  /// Half of every payload at the joint's point goes over to the chain beyond. With payloads there on both bodies the spec says itself
  /// which share is whose.
  void open_loop(int j) {
    const Joint& at = joint(j);
    bool on_first = false, on_second = false;
    VectorX over = VectorX::Zero(columns_.count());  // from the first body's chain to the second's
    for (std::size_t a = 0; a < whole_.attachments.size() && is_point_joint(at.type); ++a) {
      const Attachment& payload = whole_.attachments[a];
      const bool first = payload.body == at.first, second = payload.body == at.second;
      if (payload.kind != AttachmentKind::payload || (!first && !second)) continue;
      const Vector3 gap = payload.position - (first ? at.point_first : at.point_second);
      if (gap.norm() > coincidence_tolerance * characteristic_length(whole_)) continue;
      (first ? on_first : on_second) = true;
      over[columns_.first(ParameterOwner::attachment, static_cast<int>(a))] = first ? 0.5 : -0.5;
    }
    if (on_first && on_second) {
      split_.notes.push_back(
          fmt::format("at {}, {} and {} keep their own payloads", at.name, name(at.first), name(at.second)));
      return;
    }
    if (over.isZero(0)) return;
    add_tip(j, at.second, -over);
    add_tip(j, at.first, over);
    split_.notes.push_back(fmt::format("at {}, {} goes over from {} to {}", at.name,
                                       linear_combination_text(parameters_, over), name(at.first), name(at.second)));
  }

  void build(int chain) {
    ChainBuilder builder(whole_, loose_, columns_);
    for (std::size_t b = 1; b < whole_.bodies.size(); ++b)
      if (cuts_.chain_of[b] == chain) builder.add_body(static_cast<int>(b));
    for (std::size_t j = 0; j < whole_.joints.size(); ++j) {
      const int a = whole_.joints[j].first, b = whole_.joints[j].second;
      const bool opened = std::find(cuts_.opened_joints.begin(), cuts_.opened_joints.end(), static_cast<int>(j)) !=
                          cuts_.opened_joints.end();
      if (!opened && builder.has_body(a) && builder.has_body(b) && (a != ground || b != ground))
        builder.add_joint(static_cast<int>(j));
    }
    const VectorX present = term_values(whole_, loose_);
    for (const TipMass& tip : tips_[static_cast<std::size_t>(chain)]) builder.add_tip(tip, present);
    builder.add_attached_elements();
    split_.chains.push_back(builder.build(split_.unassigned));
  }

  const std::string& name(BodyId body) const { return whole_.bodies[static_cast<std::size_t>(body)].name; }

  void describe() {
    std::string names, cut;
    for (const Chain& chain : split_.chains) names += (names.empty() ? "(" : ", (") + chain.name + ")";
    for (const Platform& platform : cuts_.platforms) cut += (cut.empty() ? "at " : " and at ") + name(platform.body);
    for (const int j : cuts_.opened_joints) cut += (cut.empty() ? "at joint " : " and at joint ") + joint(j).name;
    split_.notes.insert(split_.notes.begin(), fmt::format("split {} into the chains {}", cut, names));
    std::size_t couplings = 0;
    for (const Chain& chain : split_.chains) couplings += chain.mechanism.couplings.size();
    if (couplings < whole_.couplings.size())
      split_.notes.push_back(
          "couplings between different chains are left out: the chains are balanced for more motions than "
          "the mechanism has");
    if (whole_.space == SpaceKind::planar)
      for (const Platform& platform : cuts_.platforms)
        split_.notes.push_back(fmt::format(
            "the point masses have another moment of inertia than {}: {} is left over", name(platform.body),
            linear_combination_text(
                parameters_,
                split_.unassigned.row(columns_.first(ParameterOwner::body, platform.body) + 3).transpose())));
  }

  const Mechanism& whole_;
  const FreeSprings& loose_;
  Index d_;
  std::vector<Parameter> parameters_;
  ParameterColumns columns_;
  GraphPartition cuts_;
  std::vector<std::vector<TipMass>> tips_;  ///< per chain
  ChainSplit split_;
};

}  // namespace

ChainSplit split_into_chains(const Mechanism& mechanism, const FreeSprings& loose) {
  return ChainSplitter(mechanism, loose).run();
}

}  // namespace balance
