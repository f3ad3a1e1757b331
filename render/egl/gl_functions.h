// The part of OpenGL that engram uses, found at run time. The library links no GL, so it loads on
// machines without one.
#pragma once

#include <GL/glcorearb.h>

namespace engram {

// One pointer per function, named as GL names it without the prefix.
struct Gl {
#define ENGRAM_GL_FUNCTIONS(F)                                               \
  F(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                   \
  F(PFNGLATTACHSHADERPROC, AttachShader)                                     \
  F(PFNGLBINDBUFFERPROC, BindBuffer)                                         \
  F(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                               \
  F(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer)                             \
  F(PFNGLBINDTEXTUREPROC, BindTexture)                                       \
  F(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                               \
  F(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                               \
  F(PFNGLBUFFERDATAPROC, BufferData)                                         \
  F(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                 \
  F(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                                   \
  F(PFNGLCLEARBUFFERIVPROC, ClearBufferiv)                                   \
  F(PFNGLCOMPILESHADERPROC, CompileShader)                                   \
  F(PFNGLCREATEPROGRAMPROC, CreateProgram)                                   \
  F(PFNGLCREATESHADERPROC, CreateShader)                                     \
  F(PFNGLCULLFACEPROC, CullFace)                                             \
  F(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                         \
  F(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                       \
  F(PFNGLDELETESHADERPROC, DeleteShader)                                     \
  F(PFNGLDISABLEPROC, Disable)                                               \
  F(PFNGLDRAWBUFFERPROC, DrawBuffer)                                         \
  F(PFNGLDRAWBUFFERSPROC, DrawBuffers)                                       \
  F(PFNGLDRAWELEMENTSINSTANCEDBASEVERTEXBASEINSTANCEPROC,                    \
    DrawElementsInstancedBaseVertexBaseInstance)                             \
  F(PFNGLENABLEPROC, Enable)                                                 \
  F(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)               \
  F(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer)               \
  F(PFNGLFRAMEBUFFERTEXTURELAYERPROC, FramebufferTextureLayer)               \
  F(PFNGLFRONTFACEPROC, FrontFace)                                           \
  F(PFNGLGENBUFFERSPROC, GenBuffers)                                         \
  F(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                               \
  F(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers)                             \
  F(PFNGLGENTEXTURESPROC, GenTextures)                                       \
  F(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                               \
  F(PFNGLGETERRORPROC, GetError)                                             \
  F(PFNGLGETINTEGERVPROC, GetIntegerv)                                       \
  F(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                           \
  F(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                     \
  F(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                             \
  F(PFNGLGETSHADERIVPROC, GetShaderiv)                                       \
  F(PFNGLGETSTRINGPROC, GetString)                                           \
  F(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                         \
  F(PFNGLLINKPROGRAMPROC, LinkProgram)                                       \
  F(PFNGLPIXELSTOREIPROC, PixelStorei)                                       \
  F(PFNGLREADBUFFERPROC, ReadBuffer)                                         \
  F(PFNGLREADPIXELSPROC, ReadPixels)                                         \
  F(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage)                       \
  F(PFNGLRENDERBUFFERSTORAGEMULTISAMPLEPROC, RenderbufferStorageMultisample) \
  F(PFNGLSHADERSOURCEPROC, ShaderSource)                                     \
  F(PFNGLTEXIMAGE2DPROC, TexImage2D)                                         \
  F(PFNGLTEXIMAGE3DPROC, TexImage3D)                                         \
  F(PFNGLTEXPARAMETERIPROC, TexParameteri)                                   \
  F(PFNGLUNIFORM1FPROC, Uniform1f)                                           \
  F(PFNGLUNIFORM1IPROC, Uniform1i)                                           \
  F(PFNGLUNIFORM2FVPROC, Uniform2fv)                                         \
  F(PFNGLUNIFORM3FVPROC, Uniform3fv)                                         \
  F(PFNGLUNIFORM1IVPROC, Uniform1iv)                                         \
  F(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                             \
  F(PFNGLUSEPROGRAMPROC, UseProgram)                                         \
  F(PFNGLVERTEXATTRIBDIVISORPROC, VertexAttribDivisor)                       \
  F(PFNGLVERTEXATTRIBIPOINTERPROC, VertexAttribIPointer)                     \
  F(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                       \
  F(PFNGLBINDSAMPLERPROC, BindSampler)                                       \
  F(PFNGLGENSAMPLERSPROC, GenSamplers)                                       \
  F(PFNGLSAMPLERPARAMETERIPROC, SamplerParameteri)                           \
  F(PFNGLSAMPLERPARAMETERFVPROC, SamplerParameterfv)                         \
  F(PFNGLVIEWPORTPROC, Viewport)

#define ENGRAM_GL_MEMBER(type, name) type name = nullptr;
  ENGRAM_GL_FUNCTIONS(ENGRAM_GL_MEMBER)
#undef ENGRAM_GL_MEMBER
};

// Fills all pointers by `find`, eglGetProcAddress or alike. Returns the name of the first function
// that is missing, or null.
const char* load_gl(void (*(*find)(const char*))(), Gl& gl);

}  // namespace engram
