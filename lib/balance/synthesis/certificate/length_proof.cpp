#include "balance/synthesis/certificate/length_proof.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <stdexcept>
#include <utility>

namespace balance::certificate {
namespace {

/// w = 0 and σ = the lower mass limits; of inertias, zero.
BoxCertificate make_trivial_certificate(const LengthGeometry& geometry) {
  BoxCertificate result;
  result.mass_limits = list_mass_limits(geometry.linkage);
  result.unknowns = geometry.dual.unknowns;
  std::vector<double> limits;
  for (const FreeCounterweight& counterweight : geometry.linkage.counterweights) {
    result.limit_index.push_back(counterweight.lower > 0 ? static_cast<int>(limits.size()) : -1);
    if (counterweight.lower > 0) limits.push_back(counterweight.lower);
  }
  for (std::size_t i = 0; i < geometry.linkage.inertias.size(); ++i) {
    result.limit_index.push_back(static_cast<int>(limits.size()));
    limits.push_back(0);
  }
  result.multipliers = MatrixX::Zero(1, result.unknowns + static_cast<Eigen::Index>(limits.size()));
  for (std::size_t i = 0; i < limits.size(); ++i)
    result.multipliers(0, result.unknowns + static_cast<Eigen::Index>(i)) = limits[i];
  return result;
}

}  // namespace

class ProofRecorder::Lister {
 public:
  Lister(const std::vector<Part>& parts, GeometryProof& proof, double bound)
      : parts_(parts), proof_(proof), bound_(bound) {}

  void list(int index, bool is_root) {
    const Part& part = parts_[static_cast<std::size_t>(index)];
    LengthBox box = part.box;
    if (is_root && proof_.geometry.min_value >= bound_) {
      add_bound(box, proof_.geometry.min_value, make_trivial_certificate(proof_.geometry));
      return;
    }
    std::vector<ProofStep> upper_cuts;
    bool is_left = true;
    for (const BoxCut& cut : part.cuts) {
      is_left = cut.length >= 0;
      if (!is_left) {
        proof_.steps.push_back(exclude(box, cut));
        break;
      }
      add_split(box, cut.length, cut.at);
      LengthBox removed = box;
      if (cut.is_lower_removed) {
        removed.upper[cut.length] = box.lower[cut.length] = cut.at;
        proof_.steps.push_back(exclude(removed, cut));
      } else {
        removed.lower[cut.length] = box.upper[cut.length] = cut.at;
        upper_cuts.push_back(exclude(removed, cut));
      }
    }
    if (is_left) list_contracted(part, box);
    proof_.steps.insert(proof_.steps.end(), upper_cuts.rbegin(), upper_cuts.rend());
  }

 private:
  void list_contracted(const Part& part, const LengthBox& box) {
    if (part.bound >= bound_ || part.bound > proof_.geometry.max_value) {
      add_bound(box, part.bound, part.multipliers);
      return;
    }
    if (part.parts.size() != 2) throw std::logic_error("the boxes of a bound do not prove it");
    const LengthBox& low = parts_[static_cast<std::size_t>(part.parts[0])].box;
    const Eigen::Index length = numerics::max_index(box.upper - low.upper);
    add_split(box, static_cast<int>(length), low.upper[length]);
    for (const int child : part.parts) list(child, false);
  }

  static ProofStep exclude(const LengthBox& box, const BoxCut& cut) {
    ProofStep step;
    step.kind = ProofStep::Kind::excluded;
    step.box = box;
    step.condition = cut.condition;
    return step;
  }

  void add_split(const LengthBox& box, int length, double at) {
    ProofStep step;
    step.box = box;
    step.length = length;
    step.at = at;
    proof_.steps.push_back(std::move(step));
  }

  void add_bound(const LengthBox& box, double bound, const BoxCertificate& multipliers) {
    ProofStep step;
    step.kind = ProofStep::Kind::bounded;
    step.box = box;
    step.bound = bound;
    step.multipliers = multipliers;
    proof_.steps.push_back(std::move(step));
  }

  const std::vector<Part>& parts_;
  GeometryProof& proof_;
  double bound_;
};

int ProofRecorder::add(int parent, const LengthBox& box, std::vector<BoxCut> cuts) {
  const auto index = static_cast<int>(parts_.size());
  Part part;
  part.box = box;
  part.cuts = std::move(cuts);
  parts_.push_back(std::move(part));
  if (parent >= 0) parts_[static_cast<std::size_t>(parent)].parts.push_back(index);
  return index;
}

void ProofRecorder::prove(int part, double bound, const BoxCertificate& multipliers) {
  Part& proved = parts_[static_cast<std::size_t>(part)];
  proved.bound = bound;
  proved.multipliers = multipliers;
}

GeometryProof ProofRecorder::list_steps(int root, const LengthGeometry& geometry, double bound) const {
  GeometryProof proof{geometry, {}};
  Lister(parts_, proof, bound).list(root, true);
  return proof;
}

}  // namespace balance::certificate
