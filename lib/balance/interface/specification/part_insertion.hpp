#pragma once
/// The names of a part where it stands in a whole: `crank` of the part `leg1` is `leg1.crank`.

#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

struct PartPlacement {
  std::string name;            ///< of the copy, `leg1`
  std::string carrier;         ///< the body that the part's ground is a piece of, or is fixed to
  bool is_fixed_body = false;  ///< the part's ground is a body of its own, `leg1.ground`
  bool planar = true;
  std::string folder;  ///< of the part's file, seen from the whole's: what files are looked for in
};

/// Every name and every reference of a part that includes nothing, as the whole says them. Names in expressions are the part's own
/// parameters, all of them; its ground is the carrier, whose points the part's are then (`leg1.A`), or the body `leg1.ground`.
/// @param part the sections that are taken over, a mapping
void rename_part(YamlNode& part, const PartPlacement& placement);

/// The value of a key; null if there is none.
YamlNode* find_entry(YamlNode& map, const std::string& key);
const YamlNode* find_entry(const YamlNode& map, const std::string& key);
/// A scalar that stands at a place.
YamlNode scalar_node(std::string text, const NodeLocation& place);
/// Adds an entry to a mapping.
void add_entry(YamlNode& map, YamlNode key, YamlNode value);

// One part in its places in a whole.

/// What `include` says of one part. What has a value for each copy is one value for all, or a mapping by their names.
struct IncludeEntry {
  std::optional<SpecCursor> file, as, on, at, angle, rpy, quaternion, set, without;
  std::vector<SpecCursor> names;  ///< of the copies
  std::string folder;             ///< of the part's file, seen from the whole's
};

/// Reads the names that `as` gives the copies; they must be none of the document's.
/// @param taken names of other copies in the document; these are added
void read_copy_names(IncludeEntry& entry, const YamlNode& document, std::vector<std::string>& taken);

/// Puts a copy of the part into the document.
/// @param part the sections that are taken over, without parts of its own @param index into entry.names
/// @throws ReadError if it does not fit
void insert_part(const IncludeEntry& entry, YamlNode part, std::size_t index, YamlNode& document);

}  // namespace balance::specification
