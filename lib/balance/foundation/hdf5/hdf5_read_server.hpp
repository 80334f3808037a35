#pragma once
/// The child's side of Hdf5Reader: the only part of the reader that uses HDF5.

#include "balance/foundation/hdf5/sandbox_process.hpp"

#include <cstdint>
#include <string>

namespace balance::hdf5 {

enum class Hdf5Request : std::uint64_t {
  has,                ///< reply: 0 or 1
  numbers,            ///< reply: the number of dimensions and the sizes; the values follow once the client agrees
  texts,              ///< reply: the count and the texts
  groups,             ///< reply: the count and the names
  text_attribute,     ///< reply: 0, or 1 and the text
  numbers_attribute,  ///< reply: 0, or 1 and the count; the values follow
  texts_attribute,    ///< reply: the count and the texts; no texts if it does not exist
};

/// @param name of an attribute; @param max_count maximum number of texts, names, bytes or values in the answer
Message make_read_request(Hdf5Request question, const std::string& path, const std::string& name = "",
                          std::uint64_t max_count = 0);

/// Opens the file and reports whether that succeeded (1 or 0), then answers requests until the client is gone. An
/// answer starts with 1; an error starts with 0, followed by its text.
void serve_requests(const std::string& file, const MessageChannel& channel);

/// The same in a process of its own, which opens no other file: it neither follows links into others nor loads filters.
void run_read_server(const std::string& file, int socket);

}  // namespace balance::hdf5
