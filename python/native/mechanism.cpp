#include "arrays.hpp"
#include "bindings.hpp"

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/mechanism.hpp"

namespace balance::python {
namespace {

py::array vector_of_three(const Vector3& v) { return py::array_t<double>(3, v.data()); }

py::array matrix_of(const Matrix3& m) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = m;
  return py::array_t<double>({3, 3}, rows.data());
}

py::list bodies_of(const Mechanism& mechanism) {
  py::list all;
  for (const Body& body : mechanism.bodies) {
    py::dict points;
    for (const model::NamedPoint& point : body.points) points[py::str(point.name)] = vector_of_three(point.position);
    py::dict one;
    one["name"] = body.name;
    one["mass"] = body.mass;
    one["com"] = vector_of_three(body.com);
    one["inertia"] = matrix_of(body.inertia);
    one["points"] = points;
    all.append(one);
  }
  return all;
}

const std::string& name_of_body(const Mechanism& mechanism, int body) {
  return mechanism.bodies[static_cast<std::size_t>(body)].name;
}

py::list joints_of(const Mechanism& mechanism) {
  py::list all;
  for (const Joint& joint : mechanism.joints) {
    py::dict one;
    one["name"] = joint.name;
    one["type"] = name_of(joint.type);
    one["first"] = name_of_body(mechanism, joint.first);
    one["second"] = name_of_body(mechanism, joint.second);
    one["point_first"] = vector_of_three(joint.point_first);
    one["point_second"] = vector_of_three(joint.point_second);
    one["axis"] = vector_of_three(joint.axis);
    all.append(one);
  }
  return all;
}

py::list attachments_of(const Mechanism& mechanism) {
  py::list all;
  for (const Attachment& attachment : mechanism.attachments) {
    py::dict one;
    one["name"] = attachment.name;
    one["kind"] = attachment.kind == AttachmentKind::counterweight ? "counterweight" : "payload";
    one["body"] = name_of_body(mechanism, attachment.body);
    one["position"] = vector_of_three(attachment.position);
    one["mass"] = attachment.mass;
    one["inertia"] = matrix_of(attachment.inertia);
    all.append(one);
  }
  return all;
}

py::list coordinates_of(const Mechanism& mechanism) {
  py::list all;
  for (const Coordinate& one : mechanism.coordinates)
    all.append(py::make_tuple(one.name, one.kind == CoordinateKind::angle ? "rad" : "m"));
  return all;
}

py::list actuators_of(const Mechanism& mechanism) {
  py::list all;
  for (const int k : mechanism.actuators) all.append(mechanism.coordinates[static_cast<std::size_t>(k)].name);
  return all;
}

py::tuple parameters_of(const Mechanism& mechanism) {
  py::list names;
  for (const dynamics::Parameter& one : dynamics::list_parameters(mechanism)) names.append(one.name);
  return py::make_tuple(names, copied(dynamics::parameter_values(mechanism)));
}

}  // namespace

void bind_mechanism(py::module_& m) {
  py::class_<Mechanism, std::shared_ptr<Mechanism>>(m, "Mechanism")
      .def_readonly("name", &Mechanism::name)
      .def_property_readonly("planar", [](const Mechanism& one) { return one.space == SpaceKind::planar; })
      .def_property_readonly("gravity", [](const Mechanism& one) { return vector_of_three(one.gravity); })
      .def_property_readonly("bodies", &bodies_of)
      .def_property_readonly("joints", &joints_of)
      .def_property_readonly("attachments", &attachments_of)
      .def_property_readonly("coordinates", &coordinates_of)
      .def_property_readonly("actuators", &actuators_of)
      .def_property_readonly("parameters", &parameters_of)
      .def_property_readonly("total_mass", &model::total_mass)
      .def_property_readonly("characteristic_length", &model::characteristic_length);
}

}  // namespace balance::python
