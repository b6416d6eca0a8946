// What the shared library exports: all that the public headers declare, and nothing else.
//
//     namespace PROXIMA_EXPORT proxima {     // in public headers: the declarations of this block
//     class PROXIMA_HIDDEN IndexParts {      // a class of the library's own that they only name
//
// The library is compiled with hidden visibility. A class is hidden or exported with its type
// information.
#pragma once

#define PROXIMA_EXPORT [[gnu::visibility("default")]]
#define PROXIMA_HIDDEN [[gnu::visibility("hidden")]]
