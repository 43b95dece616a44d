// libpng prints an error to standard error, which is the server's log, unless its caller leaves
// libpng by a jump.  OpenImageIO takes the text of the error and returns.
#include <dlfcn.h>
#include <png.h>

namespace {

[[noreturn]] void report(png_structp png, png_const_charp what) {
  if (const auto callers = reinterpret_cast<png_error_ptr>(png_get_mem_ptr(png)); callers)
    callers(png, what);
  png_longjmp(png, 1);  // what libpng does after it has printed
}

}  // namespace

// OpenImageIO calls this one and not libpng's: the dynamic linker searches a library before those
// that it depends on.
extern "C" __attribute__((visibility("default"))) void png_set_error_fn(png_structrp png,
                                                                        png_voidp error_data,
                                                                        png_error_ptr on_error,
                                                                        png_error_ptr on_warning) {
  static const auto libpngs =
      reinterpret_cast<decltype(&png_set_error_fn)>(::dlsym(RTLD_NEXT, "png_set_error_fn"));
  // Without functions for memory, the pointer for them is free to use.
  png_set_mem_fn(png, reinterpret_cast<png_voidp>(on_error), nullptr, nullptr);
  libpngs(png, error_data, &report, on_warning);
}
