#pragma once
/// Insertion of a part into a whole, with new names: `crank` of the part `leg1` is `leg1.crank`.

#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

struct PartPlacement {
  std::string name;            ///< of the copy, `leg1`
  std::string carrier;         ///< the body that the part's ground belongs to or is fixed to
  bool is_fixed_body = false;  ///< the part's ground is a body of its own, `leg1.ground`
  bool planar = true;
  std::string folder;  ///< of the part's file, relative to the whole's; files are looked for in it
};

/// Rewrites every name and reference of a part without includes as in the whole. All names in
/// expressions are the part's own parameters. Its ground is the carrier, which then has the part's
/// points (`leg1.A`), or the body `leg1.ground`.
/// @param part mapping of the imported sections
void rename_part(YamlNode& part, const PartPlacement& placement);

/// The value of a key; nullptr if there is none.
YamlNode* find_entry(YamlNode& map, const std::string& key);
const YamlNode* find_entry(const YamlNode& map, const std::string& key);
/// A scalar at a place.
YamlNode scalar_node(std::string text, const NodeLocation& place);
/// Adds an entry to a mapping.
void add_entry(YamlNode& map, YamlNode key, YamlNode value);

// One part at its places in a whole.

/// Keys of one part in `include`. A value that may differ from copy to copy is one for all,
/// or a mapping by their names.
struct IncludeEntry {
  std::optional<SpecCursor> file, as, on, at, angle, rpy, quaternion, set, without;
  std::vector<SpecCursor> names;  ///< of the copies
  std::string folder;             ///< of the part's file, relative to the whole's
};

/// Reads the names that `as` gives the copies; the document must not have them yet.
/// @param used_names names of other copies in the document; the new ones are added
void read_copy_names(IncludeEntry& entry, const YamlNode& document, std::vector<std::string>& used_names);

/// Inserts a copy of the part into the document.
/// @param part the imported sections, without includes @param index into entry.names
/// @throws ReadError if it does not fit
void insert_part(const IncludeEntry& entry, YamlNode part, std::size_t index, YamlNode& document);

}  // namespace balance::specification
