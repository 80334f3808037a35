#pragma once
/// One part in its places in a whole. Private to spec.

#include "balance/spec/cursor.hpp"
#include "balance/spec/part_names.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

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
/// @throws Problem if it does not fit
void insert_part(const IncludeEntry& entry, YamlNode part, std::size_t index, YamlNode& document);

}  // namespace balance::specification
