#include "balance/formulas/mechanism_numbers.hpp"

#include <algorithm>

namespace balance::formulas {

namespace {

constexpr const char* letters[] = {"x", "y", "z"};
/// Of a symmetric matrix: row, column, what it is called.
struct Entry {
  int row, column;
  const char* name;
};
constexpr Entry entries[] = {{0, 0, "x"}, {1, 1, "y"}, {2, 2, "z"}, {0, 1, "xy"}, {0, 2, "xz"}, {1, 2, "yz"}};

std::string item(const std::string& path, int k) { return path.empty() ? "" : path + "[" + std::to_string(k) + "]"; }
std::string behind(const std::string& name) { return "_" + name; }
int nonzero(const Vector3& v) { return static_cast<int>((v.array() != 0).count()); }

}  // namespace

MechanismNumbers::MechanismNumbers(Ring& ring, const Mechanism& mechanism, const SpecTexts& texts,
                                   const TreeOptions& options)
    : numbers_(ring, texts, options.expressions == Expressions::put_in),
      mechanism_(mechanism),
      texts_(texts),
      origin_(options.inertial == Inertial::about_origin) {}

const NamedPoint* MechanismNumbers::named_point(int body, const Vector3& position) const {
  const NamedPoint* found = nullptr;
  const Body& owner = mechanism_.bodies[static_cast<std::size_t>(body)];
  for (const NamedPoint& point : owner.points) {
    if (point.position != position) continue;
    if (found == nullptr) found = &point;
    const std::string prefix = body == ground ? "ground.points." : "bodies." + owner.name + ".points.";
    for (int k = 0; k < 3; ++k) {
      const auto text = texts_.numbers.find(item(prefix + point.name, k));
      if (text != texts_.numbers.end() && text->second.find_first_of("abcdfghijklmnopqrstuvwxyz_") != std::string::npos)
        return &point;
    }
  }
  return found;
}

/// @param along name of the only coordinate that is not zero @param behind what follows x, y, z in the names of several
Vector MechanismNumbers::place(const std::string& path, const Vector3& position, const std::string& along,
                               const std::string& behind, SymbolKind kind) {
  Vector at;
  const bool alone = nonzero(position) == 1 && !along.empty();
  for (int k = 0; k < 3; ++k)
    at[static_cast<std::size_t>(k)] =
        numbers_.at(item(path, k), position[k], alone ? along : letters[k] + behind, kind);
  return at;
}

Vector MechanismNumbers::point(int body, const Vector3& position) {
  const auto [at, fresh] = points_.try_emplace({body, {position.x(), position.y(), position.z()}});
  if (!fresh) return at->second;
  const NamedPoint* named = named_point(body, position);
  const Body& owner = mechanism_.bodies[static_cast<std::size_t>(body)];
  const std::string number = body == ground ? "" : std::to_string(body);
  const std::string section = body == ground ? "ground" : "bodies." + owner.name;
  const std::string path = named != nullptr ? section + ".points." + named->name : "";
  std::string along;
  if (body != ground && nonzero(position) == 1 && has_length_.insert(body).second) along = "l" + number;
  at->second = place(path, position, along, (named != nullptr ? named->name : "P") + number, SymbolKind::length);
  return at->second;
}

Symmetric<Polynomial> MechanismNumbers::inertia(const MassText& text) {
  Symmetric<Polynomial> J;
  for (int k = 0; k < 6; ++k) {
    if (planar() && k != 2) continue;
    const auto [row, column, name] = entries[k];
    std::string path = planar() ? text.path + ".inertia" : item(text.path + ".inertia", k);
    if (texts_.numbers.contains(text.path + ".inertia.axial")) {
      const Matrix3& I = text.inertia;  // two of its moments are the transverse one
      const bool axial = k < 3 && I(row, row) != I((row + 1) % 3, (row + 1) % 3) &&
                         I((row + 1) % 3, (row + 1) % 3) == I((row + 2) % 3, (row + 2) % 3);
      path = k < 3 ? text.path + (axial ? ".inertia.axial" : ".inertia.transverse") : "";
    }
    J[static_cast<std::size_t>(k)] =
        numbers_.at(path, text.inertia(row, column), std::string("J") + name + text.name, SymbolKind::inertia);
  }
  return J;
}

Mass MechanismNumbers::about_com(const Polynomial& mass, const Vector& com, const MassText& text) {
  Mass part;
  part.mass = mass;
  part.inertia = inertia(text);
  return shifted(part, com);
}

Mass MechanismNumbers::about_origin(const std::string& name, double mass, const Vector3& com, const Matrix3& inertia) {
  Mass part;
  const auto symbol = [&](const std::string& letter, double value, SymbolKind kind) {
    inertial_.push_back(numbers_.ring().add_symbol(plain_name(letter + name), kind, value));
    return Polynomial::of_symbol(numbers_.ring(), inertial_.back());
  };
  const Vector3 h = mass * com;
  const Matrix3 I = inertia + mass * (com.squaredNorm() * Matrix3::Identity() - com * com.transpose());
  part.mass = symbol("m", mass, SymbolKind::mass);
  for (int k = 0; k < (planar() ? 2 : 3); ++k)
    part.moment[static_cast<std::size_t>(k)] = symbol(std::string("m") + letters[k], h[k], SymbolKind::first_moment);
  if (planar()) {
    part.inertia[2] = symbol("J", I(2, 2), SymbolKind::inertia);
    return part;
  }
  for (int k = 0; k < 6; ++k) {
    const auto [row, column, axes] = entries[k];
    const std::string both = k < 3 ? std::string(axes) + axes : axes;
    part.inertia[static_cast<std::size_t>(k)] = symbol("I" + both, I(row, column), SymbolKind::inertia);
  }
  return part;
}

Mass MechanismNumbers::body(int index) {
  const Body& body = mechanism_.bodies[static_cast<std::size_t>(index)];
  const std::string number = std::to_string(index), path = "bodies." + body.name;
  if (origin_) return about_origin(number, body.mass, body.com, body.inertia);
  const Polynomial mass = numbers_.at(path + ".mass", body.mass, "m" + number, SymbolKind::mass);
  const Vector com = place(path + ".com", body.com, "lg" + number, "g" + number, SymbolKind::place);
  return about_com(mass, com, {path, number, body.inertia});
}

/// Its own numbers, or a point of the body that carries it.
Vector MechanismNumbers::carried_at(const std::string& path, int body, const Vector3& position,
                                    const std::string& name) {
  const bool own = texts_.numbers.contains(path + ".at[0]") || named_point(body, position) == nullptr;
  return own ? place(path + ".at", position, "", name, SymbolKind::place) : point(body, position);
}

Vector MechanismNumbers::disc_place(int index) {
  const Disc& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  return carried_at("discs." + disc.name, disc.body, disc.position, behind(disc.name));
}

Mass MechanismNumbers::attachment(int index) {
  const Attachment& extra = mechanism_.attachments[static_cast<std::size_t>(index)];
  const bool payload = extra.kind == AttachmentKind::payload;
  const std::string path = (payload ? "payloads." : "counterweights.") + extra.name, name = behind(extra.name);
  if (origin_) return about_origin(name, extra.mass, extra.position, extra.inertia);
  const Polynomial mass = numbers_.at(path + ".mass", extra.mass, "m" + name, SymbolKind::mass);
  return about_com(mass, carried_at(path, extra.body, extra.position, name), {path, name, extra.inertia});
}

Mass MechanismNumbers::disc(int index) {
  const Disc& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  const std::string path = "discs." + disc.name, name = behind(disc.name);
  if (origin_) return about_origin(name, disc.mass, Vector3::Zero(), disc.inertia);
  return about_com(numbers_.at(path + ".mass", disc.mass, "m" + name, SymbolKind::mass), {},
                   {path, name, disc.inertia});
}

Vector MechanismNumbers::gravity() {
  const Vector3& g = mechanism_.gravity;
  Vector at;
  for (int k = 0; k < 3; ++k) {
    const std::string name = nonzero(g) == 1 ? "g" : std::string("g") + letters[k];
    const auto text = texts_.numbers.find(item("gravity", k));
    const bool letter =
        text != texts_.numbers.end() && text->second.find_first_of("abcdfghijklmnopqrstuvwxyz_") < text->second.size();
    const bool down = g[k] < 0 && !letter;  // g is what weighs
    const Polynomial value =
        numbers_.at(letter ? item("gravity", k) : "", down ? -g[k] : g[k], name, SymbolKind::gravity);
    at[static_cast<std::size_t>(k)] = down ? -value : value;
  }
  return at;
}

Polynomial MechanismNumbers::ratio(int index) {
  const Disc& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  return numbers_.at("discs." + disc.name + ".ratio", disc.ratio, "n_" + disc.name, SymbolKind::ratio);
}

Polynomial MechanismNumbers::coupling_ratio(std::size_t c) {
  return numbers_.at("couplings[" + std::to_string(c) + "].ratio", mechanism_.couplings[c].ratio,
                     "n" + std::to_string(c + 1), SymbolKind::ratio);
}

Polynomial MechanismNumbers::disc_term(int index, const CoordinateTerm& term) {
  const std::string& disc = mechanism_.discs[static_cast<std::size_t>(index)].name;
  const std::string& leader = mechanism_.coordinates[static_cast<std::size_t>(term.coordinate)].name;
  return numbers_.at("discs." + disc + ".follows." + leader, term.ratio, "n_" + disc + "_" + leader, SymbolKind::ratio);
}

Polynomial MechanismNumbers::coupling_term(std::size_t c, const CoordinateTerm& term) {
  const std::string& leader = mechanism_.coordinates[static_cast<std::size_t>(term.coordinate)].name;
  return numbers_.at("couplings[" + std::to_string(c) + "].follows." + leader, term.ratio,
                     "n" + std::to_string(c + 1) + "_" + leader, SymbolKind::ratio);
}

Polynomial MechanismNumbers::stiffness(std::size_t s) {
  const Spring& spring = mechanism_.springs[s];
  return numbers_.at("springs." + spring.name + ".stiffness", spring.stiffness, "k_" + spring.name,
                     SymbolKind::stiffness);
}

Polynomial MechanismNumbers::free_length(std::size_t s) {
  const Spring& spring = mechanism_.springs[s];
  return numbers_.at("springs." + spring.name + ".free_length", spring.free_length, "l0_" + spring.name,
                     SymbolKind::length);
}

/// As its spec has it: by itself, or by where the spring rests.
Polynomial MechanismNumbers::preload(std::size_t s) {
  const Spring& spring = mechanism_.springs[s];
  const std::string path = "springs." + spring.name;
  if (!texts_.numbers.contains(path + ".rest"))
    return numbers_.at(path + ".preload", spring.preload, "p_" + spring.name, SymbolKind::stiffness);
  const double rest = spring.stiffness == 0 ? 0 : spring.preload / spring.stiffness;
  return stiffness(s) * numbers_.at(path + ".rest", rest, "q0_" + spring.name, SymbolKind::place);
}

Vector MechanismNumbers::rise(int index) {
  const Joint& joint = mechanism_.joints[static_cast<std::size_t>(index)];
  const Polynomial r =
      numbers_.at("joints." + joint.name + ".radius", joint.radius, "r_" + joint.name, SymbolKind::length);
  Vector up;
  for (int k = 0; k < 3; ++k) {
    if (joint.axis[k] == 0) continue;
    if (std::abs(joint.axis[k]) != 1)
      throw FormulaError("joint " + joint.name + " rolls on a plane that is not across an axis of its body");
    up[static_cast<std::size_t>(k)] = joint.axis[k] > 0 ? r : -r;
  }
  return up;
}

std::string MechanismNumbers::coordinate_name(int index) const {
  const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(index)];
  const std::string& name = coordinate.name;
  const bool numbered = name.size() > 1 && name[0] == 'J' && name.find_first_not_of("0123456789", 1) > name.size();
  if (!numbered) return plain_name(name);
  return (coordinate.kind == CoordinateKind::angle ? "theta" : "d") + name.substr(1);
}

}  // namespace balance::formulas
