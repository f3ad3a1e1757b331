#include "render/egl/context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <cstdlib>
#include <cstring>
#include <mutex>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

[[noreturn]] void unavailable(const std::string& why) {
  throw Error(Error::kUnavailable, "EGL: " + why);
}

// A space-separated list contains the word.
bool contains(const char* list, const char* word) {
  if (list == nullptr) return false;
  const std::size_t length = std::strlen(word);
  for (const char* at = std::strstr(list, word); at != nullptr; at = std::strstr(at + 1, word)) {
    const bool starts = at == list || at[-1] == ' ';
    if (starts && (at[length] == ' ' || at[length] == '\0')) return true;
  }
  return false;
}

struct Egl {
  PFNEGLGETPROCADDRESSPROC GetProcAddress = nullptr;
  PFNEGLQUERYSTRINGPROC QueryString = nullptr;
  PFNEGLINITIALIZEPROC Initialize = nullptr;
  PFNEGLBINDAPIPROC BindAPI = nullptr;
  PFNEGLQUERYAPIPROC QueryAPI = nullptr;
  PFNEGLCHOOSECONFIGPROC ChooseConfig = nullptr;
  PFNEGLCREATECONTEXTPROC CreateContext = nullptr;
  PFNEGLDESTROYCONTEXTPROC DestroyContext = nullptr;
  PFNEGLMAKECURRENTPROC MakeCurrent = nullptr;
  PFNEGLGETCURRENTCONTEXTPROC GetCurrentContext = nullptr;
  PFNEGLGETCURRENTDISPLAYPROC GetCurrentDisplay = nullptr;
  PFNEGLGETCURRENTSURFACEPROC GetCurrentSurface = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplay = nullptr;
  PFNEGLQUERYDEVICESEXTPROC QueryDevices = nullptr;  // may be null
};

template <class Function>
void find(const Egl& egl, const char* name, Function& function) {
  function = reinterpret_cast<Function>(egl.GetProcAddress(name));
  if (function == nullptr) unavailable(std::string("libEGL.so.1 lacks ") + name);
}

Egl load_egl() {
  void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = dlerror();
    unavailable("cannot load libEGL.so.1 (Debian: libegl1): " + std::string(why ? why : ""));
  }
  Egl egl;
  egl.GetProcAddress =
      reinterpret_cast<PFNEGLGETPROCADDRESSPROC>(dlsym(library, "eglGetProcAddress"));
  if (egl.GetProcAddress == nullptr) unavailable("libEGL.so.1 lacks eglGetProcAddress");
  find(egl, "eglQueryString", egl.QueryString);
  find(egl, "eglInitialize", egl.Initialize);
  find(egl, "eglBindAPI", egl.BindAPI);
  find(egl, "eglQueryAPI", egl.QueryAPI);
  find(egl, "eglChooseConfig", egl.ChooseConfig);
  find(egl, "eglCreateContext", egl.CreateContext);
  find(egl, "eglDestroyContext", egl.DestroyContext);
  find(egl, "eglMakeCurrent", egl.MakeCurrent);
  find(egl, "eglGetCurrentContext", egl.GetCurrentContext);
  find(egl, "eglGetCurrentDisplay", egl.GetCurrentDisplay);
  find(egl, "eglGetCurrentSurface", egl.GetCurrentSurface);
  find(egl, "eglGetPlatformDisplayEXT", egl.GetPlatformDisplay);
  if (contains(egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_EXT_platform_device")) {
    find(egl, "eglQueryDevicesEXT", egl.QueryDevices);
  }
  return egl;
}

// An opened display that can have contexts without surfaces.
struct Display {
  EGLDisplay handle = EGL_NO_DISPLAY;
  EGLConfig config = nullptr;
  std::string platform;
};

class Displays {
 public:
  // Opens what is there.
  Displays() : egl(load_egl()) {
    setenv("LP_NUM_THREADS", "0", 0);
    constexpr EGLint kMaxDevices = 32;
    std::vector<EGLDeviceEXT> devices(kMaxDevices);
    EGLint count = 0;
    if (egl.QueryDevices == nullptr ||
        egl.QueryDevices(kMaxDevices, devices.data(), &count) == EGL_FALSE) {
      count = 0;
    }
    for (EGLint i = 0; i < count; ++i) {
      open(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)],
           "device " + std::to_string(i));
    }
    const char* extensions = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (contains(extensions, "EGL_MESA_platform_surfaceless")) {
      open(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, "surfaceless");
    }
    if (all.empty()) {
      unavailable("none of its " + std::to_string(count) +
                  " devices, nor a surfaceless display, gives OpenGL" + problems_ +
                  " (Debian: libegl-mesa0 and libgl1-mesa-dri draw without a GPU)");
    }
  }

  // Opened once for the process; an attempt that failed may be repeated.
  static Displays& get() {
    static Displays displays;
    return displays;
  }

  const Egl egl;
  Gl gl;  // entry points, the same for all contexts; loaded with the first
  std::once_flag gl_loaded;
  std::vector<Display> all;

 private:
  void open(EGLenum platform, void* native, const std::string& name) {
    Display display;
    display.platform = name;
    display.handle = egl.GetPlatformDisplay(platform, native, nullptr);
    const char* problem = nullptr;
    EGLint major = 0;
    EGLint minor = 0;
    if (display.handle == EGL_NO_DISPLAY ||
        egl.Initialize(display.handle, &major, &minor) == EGL_FALSE) {
      problem = "cannot be opened";
    } else if (!contains(egl.QueryString(display.handle, EGL_EXTENSIONS),
                         "EGL_KHR_surfaceless_context")) {
      problem = "lacks EGL_KHR_surfaceless_context";
    } else {
      const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                               EGL_OPENGL_BIT, EGL_NONE};
      EGLint found = 0;
      egl.ChooseConfig(display.handle, wanted, &display.config, 1, &found);
      if (found == 0) problem = "has no OpenGL";
    }
    if (problem == nullptr) {
      all.push_back(display);
    } else {
      problems_ += "; " + name + " " + problem;
    }
  }

  std::string problems_;
};

EGLContext create(const Egl& egl, const Display& display, GlProfile profile) {
  const bool core = profile == GlProfile::kCore;
  const EGLint core_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    4,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    2,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
  const EGLint any[] = {EGL_NONE};
  const EGLenum previous = egl.QueryAPI();
  if (egl.BindAPI(EGL_OPENGL_API) == EGL_FALSE) return EGL_NO_CONTEXT;
  const EGLContext context = egl.CreateContext(display.handle, display.config, EGL_NO_CONTEXT,
                                               core ? core_attributes : any);
  if (previous != EGL_NONE) egl.BindAPI(previous);
  return context;
}

bool is_software(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software"}) {
    if (renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

std::string text(const Gl& gl, GLenum name) {
  const GLubyte* value = gl.GetString(name);
  return value == nullptr ? "" : reinterpret_cast<const char*>(value);
}

}  // namespace

struct EglContext::Handles {
  Displays* displays = nullptr;
  const Display* display = nullptr;
  EGLContext context = EGL_NO_CONTEXT;

  ~Handles() {
    if (context != EGL_NO_CONTEXT) displays->egl.DestroyContext(display->handle, context);
  }
};

EglContext::EglContext(GlProfile profile) : handles_(std::make_unique<Handles>()) {
  Displays& displays = Displays::get();
  handles_->displays = &displays;
  for (const Display& display : displays.all) {
    handles_->context = create(displays.egl, display, profile);
    if (handles_->context == EGL_NO_CONTEXT) continue;
    handles_->display = &display;
    const Current current(*this);
    if (current.ok()) {
      std::call_once(displays.gl_loaded, [&displays] {
        const char* missing = load_gl(displays.egl.GetProcAddress, displays.gl);
        if (missing != nullptr) unavailable(std::string("OpenGL lacks ") + missing);
      });
      return;
    }
    displays.egl.DestroyContext(display.handle, handles_->context);
    handles_->context = EGL_NO_CONTEXT;
  }
  unavailable(std::string("no display of ") + std::to_string(displays.all.size()) + " gives " +
              (profile == GlProfile::kCore ? "OpenGL 4.2 core" : "the fixed OpenGL pipeline"));
}

EglContext::~EglContext() = default;

const Gl& EglContext::gl() const { return handles_->displays->gl; }
const std::string& EglContext::platform() const { return handles_->display->platform; }

EglContext::Current::Current(const EglContext& context) : context_(context) {
  const Egl& egl = context.handles_->displays->egl;
  display_ = egl.GetCurrentDisplay();
  draw_ = egl.GetCurrentSurface(EGL_DRAW);
  read_ = egl.GetCurrentSurface(EGL_READ);
  previous_ = egl.GetCurrentContext();
  ok_ = egl.MakeCurrent(context.handles_->display->handle, EGL_NO_SURFACE, EGL_NO_SURFACE,
                        context.handles_->context) != EGL_FALSE;
}

EglContext::Current::~Current() {
  const Egl& egl = context_.handles_->displays->egl;
  if (previous_ != EGL_NO_CONTEXT) {
    egl.MakeCurrent(display_, draw_, read_, previous_);
  } else {
    egl.MakeCurrent(context_.handles_->display->handle, EGL_NO_SURFACE, EGL_NO_SURFACE,
                    EGL_NO_CONTEXT);
  }
}

EglInfo query_egl() {
  EglInfo info;
  try {
    const EglContext context(GlProfile::kCore);
    const EglContext::Current current(context);
    info.platform = context.platform();
    info.vendor = text(context.gl(), GL_VENDOR);
    info.renderer = text(context.gl(), GL_RENDERER);
    info.version = text(context.gl(), GL_VERSION);
    info.software = is_software(info.renderer);
    info.available = true;
  } catch (const std::exception& error) {
    info.problem = error.what();
  }
  return info;
}

}  // namespace engram
