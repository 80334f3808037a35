#pragma once
/// A mechanism in one pose as lines in a plane: links, joints, the ground and what they carry. Lengths are in metres.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>
#include <vector>

namespace balance::reports {

/// Point of a picture [m], or of a line over time.
struct PlotPoint {
  double x = 0, y = 0;
};

/// Parallel projection of the world on a page.
struct Projection {
  Vector3 right = Vector3::UnitX(), up = Vector3::UnitY();  ///< orthogonal unit vectors, world axes
  std::string x_label, y_label;                             ///< what the page's axes measure: "x", "(y − x)/√2"
  bool is_spatial = false;                                  ///< it needs a third axis

  Vector3 towards_viewer() const { return right.cross(up); }
  PlotPoint apply(const Vector3& world) const { return {right.dot(world), up.dot(world)}; }
};

/// Names of projections: "xy", "xz", "yz" and "isometric" (seen from (1, 1, 1), z upwards, lengths as in the view plane).
const std::vector<std::string>& list_projections();

/// @throws std::invalid_argument for another name
Projection projection_by_name(const std::string& name);

/// Role of an outline in the drawing. They are drawn in this order, so that joints lie upon links.
enum class DrawingPart { ground, spring, link, disc, mass, slider, axis, joint, tool };

/// A line, or the border of an area, of one part.
struct Outline {
  DrawingPart part = DrawingPart::link;
  bool is_closed = false;  ///< its last point is joined to the first
  std::vector<PlotPoint> points;
};

/// Sizes of symbols in drawings of one picture.
struct DrawingScale {
  double unit = 1;           ///< about a hundredth of the picture [m]
  double heaviest_mass = 0;  ///< mass that the largest counterweight symbol stands for [kg]
};

/// The scale at which these mechanisms, moving along their runs, share one picture.
/// @param mechanisms not empty, one for each run; a run of its mechanism
DrawingScale drawing_scale(const std::vector<const Mechanism*>& mechanisms, const std::vector<const RunResult*>& runs,
                           const Projection& projection);

/// The ground: bearings of its joints, and guides as long as the run needs them.
std::vector<Outline> draw_ground(const Mechanism& mechanism, const RunResult& result, const Projection& projection,
                                 const DrawingScale& scale);

/// The moving parts at one sample, in the order of DrawingPart. A payload is drawn while it is carried.
/// @param row sample of the run
/// @throws std::invalid_argument if the run belongs to another mechanism
std::vector<Outline> draw_pose(const Mechanism& mechanism, const RunResult& result, Eigen::Index row,
                               const Projection& projection, const DrawingScale& scale);

}  // namespace balance::reports
