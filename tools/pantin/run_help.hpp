#pragma once

namespace pantin::program {

/// The end of `pantin run --help`: examples, the columns of a record, the keys of --json.
extern const char* const kRunFooter;

}  // namespace pantin::program
