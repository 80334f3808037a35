#pragma once
/// Takes one chain out of a mechanism.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance {

// The chains of a parallel mechanism as mechanisms of their own, each with point masses for its share of what they carry
// together (P0 section 2.2).

/// A chain alone: its bodies, joints and whatever hangs on them, and a payload at every tip.
struct Chain {
  std::string name;  ///< "crank1, coupler1"
  Mechanism mechanism;
  FreeSprings loose_springs;
  MatrixX parameters;  ///< π of the chain = parameters · π of the whole mechanism
};

/// The chains and what is left over are together the whole mechanism: at every moment the same forces result.
struct ChainSplit {
  std::string failure_reason;  ///< why the mechanism cannot be split; else empty
  bool is_serial = false;      ///< there is nothing to split
  std::vector<Chain> chains;
  MatrixX unassigned;  ///< P×P: parameters of the whole mechanism with everything taken off that the chains carry
  std::vector<std::string> notes;
};

/// A platform's mass and first moments, with those of everything on it, are replaced by point masses at its joints: barycentric
/// for three points in a plane, else the smallest ones with the same mass and, as far as possible, the same CoM. A payload
/// at the joint where a loop is opened is shared equally, unless both bodies have payloads there: then each keeps its own.
ChainSplit split_into_chains(const Mechanism& mechanism, const FreeSprings& loose = {});

/// Parameters of a point of mass one about the origin of the frame that it is given in.
VectorX point_mass_parameters(SpaceKind space, const Vector3& place);

/// Where the parameters of each bearer stand.
class ParameterColumns {
 public:
  explicit ParameterColumns(const std::vector<Parameter>& parameters);
  Eigen::Index first(ParameterOwner bearer, int index) const { return ranges_.at({bearer, index}).first; }
  Eigen::Index size(ParameterOwner bearer, int index) const { return ranges_.at({bearer, index}).second; }
  Eigen::Index count() const { return count_; }

 private:
  Eigen::Index count_;
  std::map<std::pair<ParameterOwner, int>, std::pair<Eigen::Index, Eigen::Index>> ranges_;
};

/// A point mass that a chain carries at the end of a joint that was cut.
struct TipMass {
  JointId joint = 0;
  int other = 0;  ///< the body beyond the joint
  VectorX mass;   ///< P: linear in the whole mechanism's parameters
};

/// Bodies first, then joints and tips, then the rest.
class ChainBuilder {
 public:
  /// @param whole, loose, columns must outlive the builder
  ChainBuilder(const Mechanism& whole, const FreeSprings& loose, const ParameterColumns& columns);

  void add_body(BodyId body);
  void add_joint(JointId joint);
  /// At the joint's point; where that point wanders over the chain's last body, on a body of its own that has no other mass.
  /// @param present the whole mechanism's parameters
  void add_tip(const TipMass& tip, const VectorX& present);
  /// What hangs on the bodies and what refers to coordinates.
  void add_attached_elements();
  /// @param left_over loses what this chain carries
  Chain build(MatrixX& left_over);

  bool has_body(BodyId body) const { return body_[static_cast<std::size_t>(body)] >= 0; }

 private:
  /// Parameters that are the same in the chain and in the whole.
  struct SharedParameters {
    ParameterOwner bearer;
    int index;
    int whole_index;
  };
  struct TipAttachment {
    int attachment;
    VectorX mass;
    Eigen::Index parameter = -1;  ///< parameter of the whole that it is, if it is one
  };

  BodyId append(const Body& body);
  void append(const Joint& joint, JointId whole);
  void add_mass(const Attachment& mass, const VectorX& linear, Eigen::Index taken = -1);
  void add_attachment(int attachment);
  void add_disc(int disc);
  void add_spring(int spring);
  void add_loads_and_friction();
  void find_coordinates();
  CoordinateId to_chain_coordinate(CoordinateId coordinate) const {
    return coordinate_[static_cast<std::size_t>(coordinate)];
  }
  bool map_to_chain(CoordinateCombination& followed) const;
  bool is_own(BodyId body) const { return body != ground && has_body(body); }

  const Mechanism& whole_;
  const FreeSprings& loose_;
  const ParameterColumns& columns_;
  Chain chain_;
  // of the whole to those of the chain, −1 for none
  std::vector<BodyId> body_;
  std::vector<CoordinateId> coordinate_;
  std::vector<JointId> joints_;  ///< of the chain to those of the whole
  std::vector<SharedParameters> carried_;
  std::vector<TipAttachment> points_;
};

}  // namespace balance
