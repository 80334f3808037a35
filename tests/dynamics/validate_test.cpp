// What makes a mechanism no mechanism, and that whatever the reader returns is one.

#include "every_config.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/validation.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <limits>
#include <stdexcept>

namespace {

using namespace balance;
using namespace balance::dynamics;
using namespace balance::model;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Two links in a row, with one of everything.
Mechanism arm(SpaceKind space) {
  const bool planar = space == SpaceKind::planar;
  Mechanism m;
  m.name = "arm";
  m.space = space;
  m.gravity = {0, -9.81, 0};
  const Matrix3 inertia =
      planar ? Matrix3(Vector3(0, 0, 0.02).asDiagonal()) : Matrix3(Vector3(0.02, 0.03, 0.04).asDiagonal());
  m.bodies = {{.name = "ground"},
              {.name = "upper", .mass = 2, .com = {0.2, 0, 0}, .inertia = inertia, .points = {{"end", {0.4, 0, 0}}}},
              {.name = "lower", .mass = 1, .com = {0.1, 0, 0}, .inertia = inertia, .points = {}}};
  m.joints = {{.name = "A", .first = 0, .second = 1},
              {.name = "B", .first = 1, .second = 2, .point_first = {0.4, 0, 0}}};
  m.coordinates = list_coordinates(space, m.joints);
  m.attachments = {{.name = "cw", .body = 1, .position = {-0.1, 0, 0}, .mass = 1}};
  m.discs = {{.name = "rotor", .body = 1, .follows = 1, .ratio = -2, .mass = 0.5}};
  m.loads = {{.name = "push", .body = 2, .arguments = {}, .force = {{1, 0, 0}}, .moment = {{0, 0, 1}}}};
  m.springs = {{.name = "s", .first = 0, .second = 2, .stiffness = 10}};
  m.friction = {{.coordinate = 0, .viscous = 0.1, .coulomb = 0.2, .breakaway = 0.3}};
  m.actuators = {0, 1};
  m.tool = Tool{2, "end", {0.2, 0, 0}};
  m.assembly = {{0, 0.3}};
  return m;
}

struct Spoiling {
  const char* what;
  std::function<void(Mechanism&)> make;
  ValidationIssueKind kind;
  ElementKind element;
  int index;
  SpaceKind space = SpaceKind::planar;
};

const std::vector<Spoiling>& mistakes() {
  using K = ValidationIssueKind;
  using E = ElementKind;
  constexpr SpaceKind spatial = SpaceKind::spatial;
  static const std::vector<Spoiling> all = {
      {"bad space", [](Mechanism& m) { m.space = static_cast<SpaceKind>(7); }, K::unknown_value, E::mechanism, 0},
      {"no bodies", [](Mechanism& m) { m.bodies.clear(); }, K::no_ground, E::mechanism, 0},
      {"ground alone", [](Mechanism& m) { m.bodies.resize(1); }, K::no_moving_body, E::mechanism, 0},
      {"gravity", [](Mechanism& m) { m.gravity.x() = none; }, K::not_finite, E::mechanism, 0},
      {"gravity across", [](Mechanism& m) { m.gravity.z() = -9.81; }, K::out_of_plane, E::mechanism, 0},
      {"heavy ground", [](Mechanism& m) { m.bodies[0].mass = 1; }, K::ground_with_mass, E::body, 0},
      {"no mass", [](Mechanism& m) { m.bodies[1].mass = 0; }, K::mass_not_positive, E::body, 1},
      {"infinite mass", [](Mechanism& m) { m.bodies[1].mass = infinite; }, K::not_finite, E::body, 1},
      {"centre of mass", [](Mechanism& m) { m.bodies[2].com.y() = none; }, K::not_finite, E::body, 2},
      {"off the plane", [](Mechanism& m) { m.bodies[2].com.z() = 0.1; }, K::out_of_plane, E::body, 2},
      {"inertia xx", [](Mechanism& m) { m.bodies[2].inertia(0, 0) = 0.1; }, K::out_of_plane, E::body, 2},
      {"negative inertia", [](Mechanism& m) { m.bodies[2].inertia(2, 2) = -1; }, K::inertia_not_positive, E::body, 2},
      {"indefinite", [](Mechanism& m) { m.bodies[2].inertia(0, 1) = m.bodies[2].inertia(1, 0) = 0.1; },
       K::inertia_not_positive, E::body, 2, spatial},
      {"lopsided", [](Mechanism& m) { m.bodies[2].inertia(0, 1) = 0.001; }, K::inertia_not_symmetric, E::body, 2,
       spatial},
      {"too long", [](Mechanism& m) { m.bodies[2].inertia(2, 2) = 0.06; }, K::inertia_triangle_violated, E::body, 2,
       spatial},
      {"two uppers", [](Mechanism& m) { m.bodies[2].name = "upper"; }, K::duplicate_name, E::body, 2},
      {"two ends", [](Mechanism& m) { m.bodies[1].points.push_back(m.bodies[1].points[0]); }, K::duplicate_name,
       E::body, 1},
      {"two As", [](Mechanism& m) { m.joints[1].name = "A"; }, K::duplicate_name, E::joint, 1},
      {"no such body", [](Mechanism& m) { m.joints[1].second = 3; }, K::index_out_of_range, E::joint, 1},
      {"negative body", [](Mechanism& m) { m.joints[1].first = -1; }, K::index_out_of_range, E::joint, 1},
      {"itself", [](Mechanism& m) { m.joints[1].first = 2; }, K::same_body, E::joint, 1},
      {"joint point", [](Mechanism& m) { m.joints[1].point_first.x() = infinite; }, K::not_finite, E::joint, 1},
      {"ball in the plane", [](Mechanism& m) { m.joints[1].type = JointType::spherical; }, K::joint_type_not_in_space,
       E::joint, 1},
      {"slot in space", [](Mechanism& m) { m.joints[1].type = JointType::pin_slot; }, K::joint_type_not_in_space,
       E::joint, 1, spatial},
      {"no type", [](Mechanism& m) { m.joints[1].type = static_cast<JointType>(99); }, K::joint_type_not_in_space,
       E::joint, 1},
      {"long axis", [](Mechanism& m) { m.joints[1].axis *= 2; }, K::axis_not_unit, E::joint, 1, spatial},
      {"tilted axis", [](Mechanism& m) { m.joints[1].axis = Vector3::UnitX(); }, K::out_of_plane, E::joint, 1},
      {"skew axes",
       [](Mechanism& m) {
         m.joints[1].type = JointType::universal;
         m.joints[1].axis2 = Vector3(1, 0, 1).normalized();
       },
       K::axes_not_perpendicular, E::joint, 1, spatial},
      {"stretch", [](Mechanism& m) { m.joints[1].rotation *= 2; }, K::rotation_not_proper, E::joint, 1},
      {"mirror", [](Mechanism& m) { m.joints[1].rotation(2, 2) = -1; }, K::rotation_not_proper, E::joint, 1, spatial},
      {"tilt", [](Mechanism& m) { m.joints[1].rotation = Vector3(1, -1, -1).asDiagonal(); }, K::out_of_plane, E::joint,
       1},
      {"no coordinates", [](Mechanism& m) { m.coordinates.clear(); }, K::coordinates_inconsistent, E::mechanism, 0},
      {"loose body", [](Mechanism& m) { m.joints.pop_back(); }, K::not_connected, E::body, 2},
      {"follows nobody", [](Mechanism& m) { m.couplings = {{.follower = 1, .leader = 2}}; }, K::index_out_of_range,
       E::coupling, 0},
      {"itself", [](Mechanism& m) { m.couplings = {{.follower = 1, .leader = 1}}; }, K::coupling_cycle, E::coupling, 0},
      {"circle",
       [](Mechanism& m) {
         m.couplings = {{.follower = 1, .leader = 0}, {.follower = 0, .leader = 1}};
       },
       K::coupling_cycle, E::coupling, 1},
      {"two leaders",
       [](Mechanism& m) {
         m.couplings = {{.follower = 1, .leader = 0}, {.follower = 1, .leader = 0}};
       },
       K::duplicate_follower, E::coupling, 1},
      {"no ratio", [](Mechanism& m) { m.couplings = {{.follower = 1, .leader = 0, .ratio = 0}}; }, K::ratio_zero,
       E::coupling, 0},
      {"endless ratio", [](Mechanism& m) { m.couplings = {{.follower = 1, .leader = 0, .ratio = infinite}}; },
       K::not_finite, E::coupling, 0},
      {"negative mass", [](Mechanism& m) { m.attachments[0].mass = -1; }, K::mass_negative, E::attachment, 0},
      {"on nothing", [](Mechanism& m) { m.attachments[0].body = 5; }, K::index_out_of_range, E::attachment, 0},
      {"empty constraint",
       [](Mechanism& m) {
         m.constraints = {{"c", {}}};
       },
       K::index_out_of_range, E::constraint, 0},
      {"factor 0",
       [](Mechanism& m) {
         m.constraints = {{"c", {{.factor = 0}}}};
       },
       K::ratio_zero, E::constraint, 0},
      {"no body",
       [](Mechanism& m) {
         m.constraints = {{"c", {{GeneralisedSpeedTerm::Kind::velocity, 0, 1, 7}}}};
       },
       K::index_out_of_range, E::constraint, 0},
      {"out of plane",
       [](Mechanism& m) {
         m.constraints = {{"c", {{GeneralisedSpeedTerm::Kind::velocity, 2, 1, 1}}}};
       },
       K::out_of_plane, E::constraint, 0},
      {"two constraints",
       [](Mechanism& m) {
         m.constraints = {{"c", {{.index = 0}}}, {"c", {{.index = 1}}}};
       },
       K::duplicate_name, E::constraint, 1},
      {"no radius",
       [](Mechanism& m) {
         m.joints[0].type = JointType::rolling_disc;
         m.coordinates = list_coordinates(m.space, m.joints);
       },
       K::negative_number, E::joint, 0, spatial},
      {"two masses", [](Mechanism& m) { m.attachments.push_back(m.attachments[0]); }, K::duplicate_name, E::attachment,
       1},
      {"disc on nothing", [](Mechanism& m) { m.discs[0].body = -2; }, K::index_out_of_range, E::disc, 0},
      {"disc behind nothing", [](Mechanism& m) { m.discs[0].follows = 2; }, K::index_out_of_range, E::disc, 0},
      {"still disc", [](Mechanism& m) { m.discs[0].ratio = 0; }, K::ratio_zero, E::disc, 0},
      {"disc's axis", [](Mechanism& m) { m.discs[0].axis *= 0; }, K::axis_not_unit, E::disc, 0},
      {"light disc", [](Mechanism& m) { m.discs[0].mass = -1; }, K::mass_negative, E::disc, 0},
      {"disc's inertia", [](Mechanism& m) { m.discs[0].inertia(2, 2) = -1; }, K::inertia_not_positive, E::disc, 0},
      {"load on nothing", [](Mechanism& m) { m.loads[0].body = 3; }, K::index_out_of_range, E::load, 0},
      {"set down before", [](Mechanism& m) { m.attachments[0].from = 1, m.attachments[0].until = 0.5; },
       K::empty_payload_interval, E::attachment, 0},
      {"taken up never", [](Mechanism& m) { m.attachments[0].from = std::numeric_limits<double>::quiet_NaN(); },
       K::empty_payload_interval, E::attachment, 0},
      {"no force", [](Mechanism& m) { m.loads[0].force.clear(); }, K::load_table, E::load, 0},
      {"uneven",
       [](Mechanism& m) {
         m.loads[0].arguments = {0, 1};
       },
       K::load_table, E::load, 0},
      {"back in time",
       [](Mechanism& m) {
         m.loads[0].arguments = {0, 0};
         m.loads[0].force.resize(2), m.loads[0].moment.resize(2);
       },
       K::load_table, E::load, 0},
      {"no time", [](Mechanism& m) { m.loads[0].arguments = {none}; }, K::not_finite, E::load, 0},
      {"over nothing",
       [](Mechanism& m) {
         m.loads[0].arguments = {0, 1}, m.loads[0].coordinate = 99;
         m.loads[0].force.resize(2), m.loads[0].moment.resize(2);
       },
       K::index_out_of_range, E::load, 0},
      {"over a coordinate, but constant", [](Mechanism& m) { m.loads[0].coordinate = 0; }, K::load_table, E::load, 0},
      {"not closed",
       [](Mechanism& m) {
         m.loads[0].arguments = {0, 1}, m.loads[0].coordinate = 0, m.loads[0].is_periodic = true;
         m.loads[0].force = {{1, 0, 0}, {2, 0, 0}}, m.loads[0].moment.resize(2, balance::Vector3::Zero());
       },
       K::load_table, E::load, 0},
      {"force across", [](Mechanism& m) { m.loads[0].force[0].z() = 1; }, K::out_of_plane, E::load, 0},
      {"moment across", [](Mechanism& m) { m.loads[0].moment[0].x() = 1; }, K::out_of_plane, E::load, 0},
      {"no frame", [](Mechanism& m) { m.loads[0].frame = static_cast<Frame>(9); }, K::unknown_value, E::load, 0},
      {"damper within", [](Mechanism& m) { m.force_elements = {{.name = "d", .first = 1, .second = 1, .damping = 1}}; },
       K::same_body, E::force_element, 0},
      {"damper that drives",
       [](Mechanism& m) { m.force_elements = {{.name = "d", .first = 0, .second = 1, .damping = -1}}; },
       K::negative_number, E::force_element, 0},
      {"table with one row",
       [](Mechanism& m) {
         m.force_elements = {{.name = "t", .first = 0, .second = 1, .table = {{1}, {2}}}};
       },
       K::force_table, E::force_element, 0},
      {"table that goes back",
       [](Mechanism& m) {
         m.force_elements = {{.name = "t", .coordinate = 0, .table = {{1, 1}, {2, 3}}}};
       },
       K::force_table, E::force_element, 0},
      {"spline with three rows",
       [](Mechanism& m) {
         m.force_elements = {{.name = "t",
                              .coordinate = 0,
                              .table = {{1, 2, 3}, {2, 3, 4}, balance::model::TableInterpolation::spline}}};
       },
       K::force_table, E::force_element, 0},
      {"table in no joint",
       [](Mechanism& m) {
         m.force_elements = {{.name = "t", .coordinate = 99, .table = {{1, 2}, {2, 3}}}};
       },
       K::index_out_of_range, E::force_element, 0},
      {"soft spring", [](Mechanism& m) { m.springs[0].stiffness = -1; }, K::negative_number, E::spring, 0},
      {"short spring", [](Mechanism& m) { m.springs[0].free_length = -1; }, K::negative_number, E::spring, 0},
      {"spring within", [](Mechanism& m) { m.springs[0].first = 2; }, K::same_body, E::spring, 0},
      {"soft spring in a joint", [](Mechanism& m) { m.springs[0] = {.name = "s", .stiffness = -1, .coordinate = 0}; },
       K::negative_number, E::spring, 0},
      {"spring in a joint without preload",
       [](Mechanism& m) {
         m.springs[0] = {.name = "s", .preload = std::numeric_limits<double>::quiet_NaN(), .coordinate = 0};
       },
       K::not_finite, E::spring, 0},
      {"spring in no joint", [](Mechanism& m) { m.springs[0] = {.name = "s", .coordinate = 99}; },
       K::index_out_of_range, E::spring, 0},
      {"spring on nothing", [](Mechanism& m) { m.springs[0].first = 9; }, K::index_out_of_range, E::spring, 0},
      {"push", [](Mechanism& m) { m.friction[0].viscous = -1; }, K::negative_number, E::friction, 0},
      {"slippery", [](Mechanism& m) { m.friction[0].breakaway = 0.1; }, K::breakaway_below_coulomb, E::friction, 0},
      {"twice", [](Mechanism& m) { m.friction.push_back(m.friction[0]); }, K::duplicate_reference, E::friction, 1},
      {"rubs nothing", [](Mechanism& m) { m.friction[0].coordinate = 2; }, K::index_out_of_range, E::friction, 0},
      {"drives nothing", [](Mechanism& m) { m.actuators[1] = 2; }, K::index_out_of_range, E::actuator, 1},
      {"drives again", [](Mechanism& m) { m.actuators[1] = 0; }, K::duplicate_reference, E::actuator, 1},
      {"tool on nothing", [](Mechanism& m) { m.tool->body = 3; }, K::index_out_of_range, E::tool, 0},
      {"rough nothing", [](Mechanism& m) { m.assembly[0].coordinate = 2; }, K::index_out_of_range, E::assembly, 0},
      {"roughly", [](Mechanism& m) { m.assembly[0].value = none; }, K::not_finite, E::assembly, 0},
  };
  return all;
}

}  // namespace

TEST_CASE("what the reader returns has no faults") {
  for (const std::string& file : doors::every_config()) {
    CAPTURE(file);
    for (const ValidationIssue& fault : validate(balance::read_spec_file(file).mechanism)) FAIL_CHECK(fault.message);
  }
}

TEST_CASE("a sound mechanism has no faults") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (const ValidationIssue& fault : validate(arm(space))) FAIL_CHECK(fault.message);
}

TEST_CASE("every mistake is found where it is, and the door refuses it") {
  for (const Spoiling& mistake : mistakes()) {
    CAPTURE(mistake.what);
    Mechanism m = arm(mistake.space);
    mistake.make(m);
    const std::vector<ValidationIssue> faults = validate(m);
    const auto found = std::find_if(faults.begin(), faults.end(), [&](const ValidationIssue& fault) {
      return fault.kind == mistake.kind && fault.element == mistake.element && fault.index == mistake.index;
    });
    CHECK(found != faults.end());
    for (const ValidationIssue& fault : faults) CHECK(!fault.message.empty());
    CHECK_THROWS_AS(InverseDynamics{m}, std::invalid_argument);
  }
}

TEST_CASE("a fault's sentence names the element and the number") {
  Mechanism m = arm(SpaceKind::planar);
  m.bodies[1].mass = -1;
  REQUIRE(validate(m).size() == 1);
  CHECK(validate(m)[0].message == "body 'upper': the mass must be positive, is -1");
  m.actuators[0] = -3;
  REQUIRE(validate(m).size() == 2);
  CHECK(validate(m)[1].message == "actuator 0: its coordinate must be one of 2 (from 0), is -3");
  CHECK_THROWS_WITH_AS(require_valid(m),
                       "body 'upper': the mass must be positive, is -1\n"
                       "actuator 0: its coordinate must be one of 2 (from 0), is -3",
                       std::invalid_argument);
}

TEST_CASE(
    "bodies without mass, point masses and inertias kept as given have no faults, whatever the space and the tool") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (const bool with_tool : {true, false})
      for (std::size_t b = 1; b <= 2; ++b) {
        Mechanism m = arm(space);
        if (!with_tool) m.tool.reset();
        m.bodies[b].inertia.setZero();
        CHECK(validate(m).empty());
        m.bodies[b].mass = 0;
        CHECK(validate(m).empty());
        CHECK(has_mass(m));
        m.bodies[b].inertia(2, 2) = -1;
        CHECK(validate(m).size() == 2);
        m.bodies[b].inertia_as_given = true;
        CHECK(validate(m).empty());
      }
}

TEST_CASE("a mechanism has mass if a body, an attachment or a disc has") {
  Mechanism m = arm(SpaceKind::planar);
  for (Body& body : m.bodies) body.mass = 0;
  m.attachments.clear();
  m.discs.clear();
  CHECK_FALSE(has_mass(m));
  m.attachments.emplace_back().mass = 1;
  CHECK(has_mass(m));
}
