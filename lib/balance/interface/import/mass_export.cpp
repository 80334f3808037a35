#include "balance/interface/import/mass_export.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/mjcf_elements.hpp"
#include "balance/interface/import/model_simplification.hpp"
#include "balance/interface/import/spec_writer.hpp"
#include "balance/interface/import/xml_document.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/motion/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace balance::foreign {

/// Edits of single numbers in the text of an XML document.
class XmlEdits {
 public:
  /// Keeps the text of an attribute whose numbers do not change. Adds a missing attribute unless
  /// its value is a single zero.
  void set(const XmlElement& at, const char* attribute, const std::vector<double>& values);
  /// Replaces an existing attribute by another one.
  void replace(const XmlElement& at, const char* attribute, const char* new_attribute,
               const std::vector<double>& values);
  /// Removes an existing attribute and the blanks before it.
  void remove(const XmlElement& at, const char* attribute);
  /// Inserts text before an element, or after an element's opening tag.
  void insert_before(const XmlElement& at, const std::string& text);
  void insert_inside(const XmlElement& at, const std::string& text);

  /// The document's text with all edits.
  std::string apply(const std::string& text);

 private:
  struct Edit {
    std::size_t begin, end;
    std::string text;
  };
  std::vector<Edit> edits_;
};

/// "1 2.5 0", each number in its shortest form that reads back the same.
std::string numbers_text(const std::vector<double>& values);

// Robot files whose masses can be written.

/// Mass, centre of mass and inertia about it, in a body's axes [kg, m, kg m²].
struct MassProperties {
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
};

class MassPropertyWriter {
 public:
  virtual ~MassPropertyWriter() = default;

  virtual ForeignModel read() const = 0;
  /// The format's word for a body, and its name.
  virtual const char* body_term() const = 0;
  virtual const char* name() const = 0;
  /// Whether mass properties can be written to this body of the model from read().
  virtual bool can_set_mass(const ForeignBody& body) const = 0;
  /// @param body one with can_set_mass()
  /// @throws SpecError if the file would ignore them, or if the body is in an included file
  virtual void write(const ForeignBody& body, const MassProperties& properties, XmlEdits& edits) const = 0;
};

/// @param document must outlive the writer
std::unique_ptr<MassPropertyWriter> make_urdf_mass_writer(const XmlDocument& document);
std::unique_ptr<MassPropertyWriter> make_mjcf_mass_writer(const XmlDocument& document);

namespace {

/// Mass, first moment and inertia about a frame's origin, which are additive.
struct MassMoments {
  double mass = 0;
  Vector3 first_moment = Vector3::Zero();
  Matrix3 second_moment = Matrix3::Zero();

  void add(double m, const Vector3& com, const Matrix3& central, double sign = 1) {
    mass += sign * m;
    first_moment += sign * m * com;
    second_moment += sign * (central - m * skew(com) * skew(com));
  }
};

std::unique_ptr<MassPropertyWriter> open_mass_writer(const XmlDocument& document) {
  if (document.root.name == "robot") return make_urdf_mass_writer(document);
  if (document.root.name == "mujoco") return make_mjcf_mass_writer(document);
  throw SpecError({.place = place_of(document.root),
                   .message = "expected <robot> or <mujoco>: only a URDF or an MJCF can be written"});
}

class MassExporter {
 public:
  MassExporter(const Study& study, const std::string& text, const std::string& file, const ImportOptions& options)
      : mechanism_(study.mechanism), spec_file_(study.spec_file), document_(parse_xml(text, file)) {
    writer_ = open_mass_writer(*document_);
    source_model_ = writer_->read();
    if (!options.loops.empty())
      read_gepetto_loops(specification::read_text_file(options.loops, "closures"),
                         specification::display_name(options.loops), source_model_);
    simplified_model_ = source_model_;
    simplify_model(simplified_model_, options);
    names_ = spec_names(simplified_model_);
  }

  MassExport run() {
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) write(static_cast<int>(b));
    const std::string reason = fmt::format("cannot be expressed in this {}: they are left out", writer_->name());
    if (!mechanism_.discs.empty()) export_.notes.push_back("discs " + reason);
    if (!mechanism_.springs.empty() || !mechanism_.force_elements.empty())
      export_.notes.push_back("springs and dampers " + reason);
    export_.text = edits_.apply(document_->text);
    return std::move(export_);
  }

 private:
  /// The merged body with this name in the spec.
  int find_simplified_body(const std::string& name) const {
    for (std::size_t b = 1; b < names_.bodies.size(); ++b)
      if (simplified_model_.bodies[b].is_active && names_.bodies[b] == name) return static_cast<int>(b);
    throw SpecError({.place = {.file = spec_file_},
                     .message = fmt::format("body {}: {} has no {} for it", quote_for_message(name), document_->file,
                                            writer_->body_term())});
  }

  MassMoments target_moments(int body) const {
    const Body& target_body = mechanism_.bodies[static_cast<std::size_t>(body)];
    MassMoments moments;
    moments.add(target_body.mass, target_body.com, target_body.inertia);
    for (const Attachment& attachment : mechanism_.attachments)
      if (attachment.body == body && attachment.kind == AttachmentKind::counterweight)
        moments.add(attachment.mass, attachment.position, attachment.inertia);
    return moments;
  }

  /// The links of a body with their poses in it, the owner first.
  std::vector<MergedBody> links_of(int merged) const {
    std::vector<MergedBody> links{{merged, {}}};
    const auto& members = simplified_model_.bodies[static_cast<std::size_t>(merged)].merged_bodies;
    links.insert(links.end(), members.begin(), members.end());
    return links;
  }

  const Body& link(int index) const { return source_model_.bodies[static_cast<std::size_t>(index)].body; }
  const ForeignBody& source_body(const MergedBody& member) const {
    return source_model_.bodies[static_cast<std::size_t>(member.body)];
  }

  void write(int body) {
    const std::string& name = mechanism_.bodies[static_cast<std::size_t>(body)].name;
    const int merged = find_simplified_body(name);
    MassMoments remaining_moments = target_moments(body);
    const std::vector<MergedBody> links = links_of(merged);
    if (is_unchanged(remaining_moments, simplified_model_.bodies[static_cast<std::size_t>(merged)].body)) return;
    auto receiving_link = std::find_if(links.begin(), links.end(), [&](const MergedBody& one) {
      return source_body(one).has_inertial && writer_->can_set_mass(source_body(one));
    });
    if (receiving_link == links.end())
      receiving_link = std::find_if(links.begin(), links.end(),
                                    [&](const MergedBody& one) { return writer_->can_set_mass(source_body(one)); });
    if (receiving_link == links.end())
      throw SpecError({.place = simplified_model_.bodies[static_cast<std::size_t>(merged)].place,
                       .message = fmt::format("{} {}: has no <inertial> for a mass of {:.6g} kg", writer_->body_term(),
                                              quote_for_message(link(merged).name), remaining_moments.mass)});
    for (const MergedBody& one : links)
      if (one.body != receiving_link->body) {
        const Body& source = link(one.body);
        remaining_moments.add(source.mass, one.pose.p + one.pose.R * source.com,
                              one.pose.R * source.inertia * one.pose.R.transpose(), -1);
      }
    write_link(source_body(*receiving_link), receiving_link->pose, remaining_moments);
  }

  /// Whether the mass properties agree up to rounding: then the file's own numbers stay.
  static bool is_unchanged(const MassMoments& target, const Body& body) {
    MassMoments current;
    current.add(body.mass, body.com, body.inertia);
    const double tolerance = 1e-14;
    return std::abs(target.mass - current.mass) <= tolerance * std::abs(current.mass) &&
           (target.first_moment - current.first_moment).norm() <= tolerance * current.first_moment.norm() &&
           (target.second_moment - current.second_moment).norm() <= tolerance * current.second_moment.norm();
  }

  /// @param pose of the link in the body
  void write_link(const ForeignBody& link, const Pose& pose, const MassMoments& moments) {
    if (!(moments.mass > 0))
      throw SpecError({.place = link.place,
                       .message = fmt::format("{} {}: its mass would be {:.6g} kg", writer_->body_term(),
                                              quote_for_message(link.body.name), moments.mass)});
    const Vector3 com = moments.first_moment / moments.mass;
    const Matrix3 central = moments.second_moment + moments.mass * skew(com) * skew(com);
    writer_->write(link, {moments.mass, pose.R.transpose() * (com - pose.p), pose.R.transpose() * central * pose.R},
                   edits_);
    export_.changed.push_back(link.body.name);
  }

  const Mechanism& mechanism_;
  std::string spec_file_;
  std::unique_ptr<const XmlDocument> document_;
  std::unique_ptr<MassPropertyWriter> writer_;
  ForeignModel source_model_, simplified_model_;
  GeneratedNames names_;
  XmlEdits edits_;
  MassExport export_;
};

}  // namespace

MassExport export_masses(const Study& study, const std::string& text, const std::string& file,
                         const ImportOptions& options) {
  reject_temporary_payloads(study, "the masses of another file");
  return MassExporter(study, text, file, options).run();
}

std::string format_balancing_elements_csv(const Mechanism& mechanism) {
  std::string text = "name,kind,body,x,y,z,mass,ixx,iyy,izz,ixy,ixz,iyz\n";
  const auto add = [&](const std::string& name, const char* kind, int body, const Vector3& p, double mass,
                       const Matrix3& I) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", name, kind,
                        mechanism.bodies[static_cast<std::size_t>(body)].name, format_yaml_number(p.x()),
                        format_yaml_number(p.y()), format_yaml_number(p.z()), format_yaml_number(mass),
                        format_yaml_number(I(0, 0)), format_yaml_number(I(1, 1)), format_yaml_number(I(2, 2)),
                        format_yaml_number(I(0, 1)), format_yaml_number(I(0, 2)), format_yaml_number(I(1, 2)));
  };
  for (const Attachment& one : mechanism.attachments)
    if (one.kind == AttachmentKind::counterweight)
      add(one.name, "counterweight", one.body, one.position, one.mass, one.inertia);
  for (const Disc& one : mechanism.discs) add(one.name, "disc", one.body, one.position, one.mass, one.inertia);
  return text;
}

namespace {

bool same_place(const SourceLocation& a, const SourceLocation& b) {
  return a.file == b.file && a.line == b.line && a.column == b.column;
}

class MjcfMasses : public MassPropertyWriter {
 public:
  explicit MjcfMasses(const XmlDocument& document) : document_(document), tree_(expand_mjcf_includes(document)) {}

  ForeignModel read() const override { return read_mjcf(document_); }
  const char* body_term() const override { return "body"; }
  const char* name() const override { return "MJCF"; }
  /// Of a chain of joints only the last body exists in the file.
  bool can_set_mass(const ForeignBody& body) const override { return find_body(tree_.root, body.place) != nullptr; }

  void write(const ForeignBody& body, const MassProperties& properties, XmlEdits& edits) const override {
    const XmlElement& element = *find_body(tree_.root, body.place);
    if (element.document != &document_)
      throw SpecError({.place = body.place,
                       .message = fmt::format("body {}: is in an included file, which is not written",
                                              quote_for_message(body.body.name))});
    if (uses_geom_masses())
      throw SpecError({.place = body.place,
                       .message = fmt::format("body {}: its mass follows from its shapes (inertiafromgeom=\"true\")",
                                              quote_for_message(body.body.name))});
    if (const XmlElement* inertial = element.child("inertial"))
      change(*inertial, properties, edits);
    else
      add(element, properties, edits);
  }

 private:
  static const XmlElement* find_body(const XmlElement& parent, const SourceLocation& place) {
    for (const XmlElement& child : parent.children) {
      if (child.name == "body" && same_place(place_of(child), place)) return &child;
      if (const XmlElement* descendant = find_body(child, place)) return descendant;
    }
    return nullptr;
  }

  bool uses_geom_masses() const {
    bool uses_geoms = false;
    for (const XmlElement& child : tree_.root.children)
      if (const std::string* rule = child.name == "compiler" ? child.attribute("inertiafromgeom") : nullptr)
        uses_geoms = *rule == "true";
    return uses_geoms;
  }

  static std::vector<double> inertia_entries(const Matrix3& I) {
    return {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  }

  /// A full inertia is in the body's axes: MuJoCo accepts no orientation beside it.
  void change(const XmlElement& at, const MassProperties& properties, XmlEdits& edits) const {
    edits.set(at, "pos", {properties.com.x(), properties.com.y(), properties.com.z()});
    edits.set(at, "mass", {properties.mass});
    ForeignDiagnostics diagnostics;
    const XmlAttributeReader reader(diagnostics);
    const Matrix3 R = MjcfCompilerAngles(tree_.root, reader, diagnostics).orientation(at);
    const Matrix3 I = R.transpose() * properties.inertia * R;
    const Vector3 diagonal = I.diagonal();
    const bool is_diagonal = (I - Matrix3(diagonal.asDiagonal())).norm() <= 1e-14 * I.norm();
    if (at.attribute("fullinertia") != nullptr) return edits.set(at, "fullinertia", inertia_entries(I));
    if (is_diagonal) return edits.set(at, "diaginertia", {diagonal.x(), diagonal.y(), diagonal.z()});
    if (at.attribute("diaginertia") != nullptr)
      edits.replace(at, "diaginertia", "fullinertia", inertia_entries(properties.inertia));
    else
      edits.set(at, "fullinertia", inertia_entries(properties.inertia));
    for (const char* attribute : {"quat", "axisangle", "euler", "xyaxes", "zaxis"})
      if (at.attribute(attribute) != nullptr) edits.remove(at, attribute);
  }

  static void add(const XmlElement& body, const MassProperties& properties, XmlEdits& edits) {
    const std::vector<double> com{properties.com.x(), properties.com.y(), properties.com.z()};
    edits.insert_inside(
        body, fmt::format("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>", numbers_text(com),
                          numbers_text({properties.mass}), numbers_text(inertia_entries(properties.inertia))));
  }

  const XmlDocument& document_;
  ExpandedMjcf tree_;
};

}  // namespace

std::unique_ptr<MassPropertyWriter> make_mjcf_mass_writer(const XmlDocument& document) {
  return std::make_unique<MjcfMasses>(document);
}

namespace {

class UrdfMasses : public MassPropertyWriter {
 public:
  explicit UrdfMasses(const XmlDocument& document) : document_(document) {}

  ForeignModel read() const override { return read_urdf(document_); }
  const char* body_term() const override { return "link"; }
  const char* name() const override { return "URDF"; }
  bool can_set_mass(const ForeignBody& body) const override { return body.has_inertial; }

  void write(const ForeignBody& body, const MassProperties& properties, XmlEdits& edits) const override {
    const XmlElement& inertial = *find_link(body.body.name)->child("inertial");
    const XmlElement* origin = inertial.child("origin");
    Matrix3 orientation = Matrix3::Identity();
    if (origin != nullptr && origin->attribute("rpy") != nullptr) {
      const auto v =
          parse_number_list(*origin->attribute("rpy")).value_or(std::vector<double>(3));  // the reader has checked it
      orientation = rotation_from_rpy({v[0], v[1], v[2]});
    }
    const Matrix3 I = orientation.transpose() * properties.inertia * orientation;
    edits.set(*inertial.child("mass"), "value", {properties.mass});
    write_com(inertial, origin, properties.com, edits);
    if (const XmlElement* inertia = inertial.child("inertia"))
      for (const auto& [key, i, j] :
           {std::tuple{"ixx", 0, 0}, {"ixy", 0, 1}, {"ixz", 0, 2}, {"iyy", 1, 1}, {"iyz", 1, 2}, {"izz", 2, 2}})
        edits.set(*inertia, key, {I(i, j)});
  }

 private:
  const XmlElement* find_link(const std::string& name) const {
    for (const XmlElement& element : document_.root.children)
      if (element.name == "link" && element.attribute("name") != nullptr && *element.attribute("name") == name)
        return &element;
    return nullptr;
  }

  static void write_com(const XmlElement& inertial, const XmlElement* origin, const Vector3& com, XmlEdits& edits) {
    const std::vector<double> xyz{com.x(), com.y(), com.z()};
    if (origin != nullptr && origin->attribute("xyz") != nullptr) return edits.set(*origin, "xyz", xyz);
    if (com.isZero(0)) return;
    if (origin != nullptr) return edits.set(*origin, "xyz", xyz);
    edits.insert_before(*inertial.child("mass"), fmt::format("<origin xyz=\"{}\"/>", numbers_text(xyz)));
  }

  const XmlDocument& document_;
};

}  // namespace

std::unique_ptr<MassPropertyWriter> make_urdf_mass_writer(const XmlDocument& document) {
  return std::make_unique<UrdfMasses>(document);
}

std::string numbers_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + format_yaml_number(value);
  return text;
}

void XmlEdits::set(const XmlElement& at, const char* attribute, const std::vector<double>& values) {
  const std::string* old_text = at.attribute(attribute);
  if (old_text != nullptr && parse_number_list(*old_text).value_or(std::vector<double>{}) == values) return;
  const XmlSpan span = value_span(at, attribute);
  const std::size_t name_end = at.offset + at.name.size();
  if (span.end > span.begin)
    edits_.push_back({span.begin, span.end, numbers_text(values)});
  else if (values != std::vector<double>{0})
    edits_.push_back({name_end, name_end, fmt::format(" {}=\"{}\"", attribute, numbers_text(values))});
}

void XmlEdits::replace(const XmlElement& at, const char* attribute, const char* new_attribute,
                       const std::vector<double>& values) {
  const XmlSpan span = value_span(at, attribute);
  const std::string& text = at.document->text;
  const std::size_t begin = text.rfind(attribute, span.begin);
  edits_.push_back(
      {begin, span.end, fmt::format("{}={}{}", new_attribute, text[span.begin - 1], numbers_text(values))});
}

void XmlEdits::remove(const XmlElement& at, const char* attribute) {
  const XmlSpan span = value_span(at, attribute);
  const std::string& text = at.document->text;
  std::size_t begin = text.rfind(attribute, span.begin);
  while (begin > 0 && std::string_view(" \t\r\n").find(text[begin - 1]) != std::string_view::npos) --begin;
  edits_.push_back({begin, span.end + 1, ""});
}

void XmlEdits::insert_before(const XmlElement& at, const std::string& text) {
  edits_.push_back({at.offset - 1, at.offset - 1, text});
}

void XmlEdits::insert_inside(const XmlElement& at, const std::string& text) {
  const std::string& document_text = at.document->text;
  char quote = 0;
  std::size_t end = at.offset;
  for (; end < document_text.size() && (quote != 0 || document_text[end] != '>'); ++end)
    if (quote != 0 ? document_text[end] == quote : document_text[end] == '"' || document_text[end] == '\'')
      quote = quote != 0 ? 0 : document_text[end];
  if (end > 0 && document_text[end - 1] == '/')  // a self-closing element is opened
    edits_.push_back({end - 1, end + 1, fmt::format(">{}</{}>", text, at.name)});
  else
    edits_.push_back({end + 1, end + 1, text});
}

std::string XmlEdits::apply(const std::string& text) {
  std::stable_sort(edits_.begin(), edits_.end(), [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
  std::string result;
  std::size_t copied_end = 0;
  for (const Edit& edit : edits_) {
    result += text.substr(copied_end, edit.begin - copied_end) + edit.text;
    copied_end = edit.end;
  }
  return result + text.substr(copied_end);
}

}  // namespace balance::foreign
