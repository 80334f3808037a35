#pragma once
/// Splits a mechanism into its chains.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance::conditions {

// Each chain of a parallel mechanism becomes a mechanism of its own, with point masses for its share of what the chains
// carry together (P0 section 2.2).

/// A single chain: its bodies and joints, the elements attached to them, and a payload at every tip.
struct Chain {
  std::string name;  ///< "crank1, coupler1"
  Mechanism mechanism;
  dynamics::FreeSprings loose_springs;
  MatrixX parameters;  ///< π of the chain = parameters · π of the whole mechanism
};

/// The chains and the unassigned remainder are together the whole mechanism: they produce the same forces at all times.
struct ChainSplit {
  std::string failure_reason;  ///< why the mechanism cannot be split; empty otherwise
  bool is_serial = false;      ///< there is nothing to split
  std::vector<Chain> chains;
  MatrixX unassigned;  ///< P×P: maps the whole mechanism's parameters to what remains without the chains' shares
  std::vector<std::string> notes;
};

/// Replaces the mass and first moments of each platform, with everything on it, by point masses at its joints:
/// barycentric for three points in a plane, otherwise of minimum norm with the same mass and, as far as possible, the
/// same CoM. Both sides of an opened loop share a payload at the opened joint equally, unless both bodies have payloads
/// there: then each keeps its own.
ChainSplit split_into_chains(const Mechanism& mechanism, const dynamics::FreeSprings& loose = {});

/// Parameters of a unit point mass about the origin of the frame in which its position is given.
VectorX point_mass_parameters(SpaceKind space, const Vector3& position);

/// Range of columns of each owner's parameters.
class ParameterColumns {
 public:
  explicit ParameterColumns(const std::vector<dynamics::Parameter>& parameters);
  Eigen::Index first(dynamics::ParameterOwner owner_kind, int index) const {
    return ranges_.at({owner_kind, index}).first;
  }
  Eigen::Index size(dynamics::ParameterOwner owner_kind, int index) const {
    return ranges_.at({owner_kind, index}).second;
  }
  Eigen::Index count() const { return count_; }

 private:
  Eigen::Index count_;
  std::map<std::pair<dynamics::ParameterOwner, int>, std::pair<Eigen::Index, Eigen::Index>> ranges_;
};

/// A point mass that a chain carries at a joint that was cut.
struct TipMass {
  JointId joint = 0;
  int other = 0;  ///< the body on the other side of the joint
  VectorX mass;   ///< P: linear in the whole mechanism's parameters
};

/// Add bodies first, then joints and tips, then the rest.
class ChainBuilder {
 public:
  /// @param whole, loose, columns must outlive the builder
  ChainBuilder(const Mechanism& whole, const dynamics::FreeSprings& loose, const ParameterColumns& columns);

  void add_body(BodyId body);
  void add_joint(JointId joint);
  /// Adds the mass at the joint's point. If that point moves on the chain's last body, the mass gets an otherwise
  /// massless body of its own.
  /// @param current_values of the whole mechanism's parameters
  void add_tip(const TipMass& tip, const VectorX& current_values);
  /// Adds the elements attached to the bodies and those that refer to coordinates.
  void add_attached_elements();
  /// @param remainder_map this chain's share is removed from it
  Chain build(MatrixX& remainder_map);

  bool has_body(BodyId body) const { return chain_body_[static_cast<std::size_t>(body)] >= 0; }

 private:
  /// Parameters that are identical in the chain and in the whole mechanism.
  struct SharedParameters {
    dynamics::ParameterOwner owner_kind;
    int index;
    int whole_index;
  };
  struct TipAttachment {
    int attachment;
    VectorX mass;
    Eigen::Index parameter = -1;  ///< the parameter of the whole mechanism that the mass equals; −1: none
  };

  BodyId append(const Body& body);
  void append(const Joint& joint, JointId whole);
  void add_mass(const Attachment& mass, const VectorX& coefficients, Eigen::Index parameter = -1);
  void add_attachment(int attachment);
  void add_disc(int disc);
  void add_spring(int spring);
  void add_known_terms();
  void find_coordinates();
  CoordinateId to_chain_coordinate(CoordinateId coordinate) const {
    return chain_coordinate_[static_cast<std::size_t>(coordinate)];
  }
  bool map_to_chain(model::CoordinateCombination& followed) const;
  template <class Element>
  bool map_ends_to_chain(Element& element) const;
  bool is_chain_body(BodyId body) const { return body != model::ground && has_body(body); }

  const Mechanism& whole_;
  const dynamics::FreeSprings& loose_;
  const ParameterColumns& columns_;
  Chain chain_;
  // ids in the chain for ids in the whole mechanism; −1: not in the chain
  std::vector<BodyId> chain_body_;
  std::vector<CoordinateId> chain_coordinate_;
  std::vector<JointId> whole_joints_;  ///< for joints of the chain: ids in the whole mechanism
  std::vector<SharedParameters> shared_parameters_;
  std::vector<TipAttachment> tip_attachments_;
};

}  // namespace balance::conditions
