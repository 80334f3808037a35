#include "balance/synthesis/certificate/virtual_linkage.hpp"

#include <algorithm>
#include <tuple>

namespace balance::certificate {
namespace {

class VirtualLinkageBuilder {
 public:
  VirtualLinkageBuilder(const PlanarLinkage& linkage, const VectorX& lengths)
      : linkage_(linkage), lengths_(lengths), bodies_(linkage.body_names.size()) {}

  VirtualLinkageResult build() {
    if (!choose_pivots()) return {{}, "a loop has no link of its own to be solved for"};
    choose_scales();
    if (!solve_closures()) return {{}, "the closures cannot be scaled by the links' lengths"};
    VirtualLinkage result;
    for (std::size_t k = 1; k < bodies_; ++k)
      if (pivot_closure_[k] < 0) unknown_bodies_.push_back(static_cast<int>(k));
    result.unknowns = 2 * static_cast<int>(unknown_bodies_.size());
    for (const FreeCounterweight& counterweight : linkage_.counterweights) {
      auto& corners = result.corners.emplace_back();
      for (const LengthPolynomial& corner : counterweight.corners)
        corners.push_back(scale_height(position(counterweight.body, corner)));
    }
    BodySum moments;
    for (const CarriedMass& carried : linkage_.masses)
      moments = moments + position(carried.body, carried.place) * carried.mass;
    result.fixed_masses = scale_height(moments);
    result.fixed_size = linkage_.fixed_size.real() * result.fixed_masses.scale;
    for (std::size_t k = 1; k < bodies_; ++k) result.positive.push_back(scales_[k]);
    return {std::move(result), {}};
  }

 private:
  LengthPolynomial one() const { return LengthPolynomial::constant(linkage_.variables, 1); }

  BodySum position(int body, const LengthPolynomial& place) const {
    return linkage_.tree_joints[static_cast<std::size_t>(body)] + BodySum{{body, place}};
  }

  /// With a size that is positive at the given lengths.
  std::optional<PolarForm> positive_polar_form(const LengthPolynomial& p) const {
    auto form = find_polar_form(p);
    if (form && form->size.evaluate(lengths_).real() < 0) {
      form->unit = -form->unit;
      form->size = -form->size;
    }
    return form;
  }

  /// Every closure is solved for a link that no other closure has.
  bool choose_pivots() {
    pivot_closure_.assign(bodies_, -1);
    pivot_forms_.resize(linkage_.closures.size());
    pivots_.assign(linkage_.closures.size(), -1);
    for (std::size_t j = 0; j < linkage_.closures.size(); ++j) {
      std::tuple<bool, int, int> best_key;
      for (const auto& [body, coefficient] : linkage_.closures[j].links) {
        const auto form = positive_polar_form(coefficient);
        const auto has_body = [body = body](const LoopClosure& c) { return c.links.count(body) > 0; };
        if (!form || std::count_if(linkage_.closures.begin(), linkage_.closures.end(), has_body) != 1) continue;
        // a link between two joints; far from the ground, so that its own rows are the long ones
        const auto k = static_cast<std::size_t>(body);
        const std::tuple<bool, int, int> key{linkage_.joint_places[k].size() != 1,
                                             -static_cast<int>(linkage_.tree_joints[k].size()), body};
        if (pivots_[j] >= 0 && !(key < best_key)) continue;
        best_key = key;
        pivots_[j] = body;
        pivot_forms_[j] = *form;
      }
      if (pivots_[j] < 0) return false;
      pivot_closure_[static_cast<std::size_t>(pivots_[j])] = static_cast<int>(j);
    }
    return true;
  }

  void choose_scales() {
    scales_.assign(bodies_, one());
    for (std::size_t k = 1; k < bodies_; ++k) {
      if (pivot_closure_[k] >= 0) {
        scales_[k] = pivot_forms_[static_cast<std::size_t>(pivot_closure_[k])].size;
      } else if (linkage_.joint_places[k].size() == 1) {
        const auto form = positive_polar_form(linkage_.joint_places[k].front());
        if (form && !form->size.constant_value()) scales_[k] = form->size;
      }
    }
  }

  /// w of a pivot as a sum of the unknowns: −Σ L_k η_k / unit over the others.
  bool solve_closures() {
    solutions_.resize(bodies_);
    for (std::size_t k = 1; k < bodies_; ++k) solutions_[k] = BodySum{{static_cast<int>(k), one()}};
    for (std::size_t j = 0; j < linkage_.closures.size(); ++j) {
      BodySum solution;
      for (const auto& [body, coefficient] : linkage_.closures[j].links) {
        if (body == pivots_[j]) continue;
        const auto quotient = coefficient.divide(scales_[static_cast<std::size_t>(body)]);
        if (!quotient) return false;
        solution[body] = *quotient * (-std::conj(pivot_forms_[j].unit));
      }
      solutions_[static_cast<std::size_t>(pivots_[j])] = std::move(solution);
    }
    return true;
  }

  /// Σ_k coefficient_k η_k in the unknowns, times the lengths by which it must be multiplied.
  VirtualHeight scale_height(const BodySum& sum) const {
    VirtualHeight height{one(), {}};
    for (const auto& [body, coefficient] : sum) {
      const LengthPolynomial& scale = scales_[static_cast<std::size_t>(body)];
      if (!(coefficient * height.scale).divide(scale)) height.scale = height.scale * scale;
    }
    BodySum unknowns;
    for (const auto& [body, coefficient] : sum) {
      const auto quotient = (coefficient * height.scale).divide(scales_[static_cast<std::size_t>(body)]);
      unknowns = unknowns + solutions_[static_cast<std::size_t>(body)] * *quotient;
    }
    for (const int body : unknown_bodies_) {
      const auto found = unknowns.find(body);
      const LengthPolynomial p = found == unknowns.end() ? LengthPolynomial() : found->second;
      height.coefficients.push_back(p.real());
      height.coefficients.push_back((p * imaginary_unit).real());
    }
    return height;
  }

  const PlanarLinkage& linkage_;
  const VectorX& lengths_;
  std::size_t bodies_;
  std::vector<int> pivots_;         ///< per closure: the body it is solved for
  std::vector<int> pivot_closure_;  ///< per body: the closure solved for it; −1: none
  std::vector<PolarForm> pivot_forms_;
  std::vector<LengthPolynomial> scales_;  ///< per body: s_k
  std::vector<BodySum> solutions_;        ///< per body: its w as a sum of unknowns
  std::vector<int> unknown_bodies_;
};

}  // namespace

VirtualLinkageResult make_virtual_linkage(const PlanarLinkage& linkage, const VectorX& lengths) {
  return VirtualLinkageBuilder(linkage, lengths).build();
}

}  // namespace balance::certificate
