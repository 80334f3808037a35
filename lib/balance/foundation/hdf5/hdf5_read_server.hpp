#pragma once
/// The child's side of Hdf5Reader: the only place of this room that knows HDF5.

#include "balance/foundation/hdf5/sandbox_process.hpp"

#include <cstdint>
#include <string>

namespace balance {

enum class Hdf5Request : std::uint64_t {
  has,                ///< answered by 0 or 1
  numbers,            ///< by the count of sizes and the sizes; the values follow as soon as somebody says to go on
  texts,              ///< by their count and the texts
  groups,             ///< by the count and the names
  text_attribute,     ///< by 0, or 1 and the text
  numbers_attribute,  ///< by 0, or 1 and the count; the values follow
  texts_attribute,    ///< by their count and the texts; none if it does not exist
};

/// @param name of an attribute; @param most texts, names, bytes or values that the answer may have
Message make_read_request(Hdf5Request question, const std::string& path, const std::string& name = "",
                          std::uint64_t most = 0);

/// Opens the file and says whether that went well (1 or 0), then answers questions until nobody asks any more. Before an answer stands 1,
/// before a complaint, which is a text, 0.
void serve_requests(const std::string& file, const MessageChannel& wire);

/// The same in a process of its own, which keeps out of every other file: neither links into one are followed nor are filters loaded.
void run_read_server(const std::string& file, int socket);

}  // namespace balance
