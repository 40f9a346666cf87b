// SPDX-License-Identifier: MIT
// Macros of other people's headers, under their names: a host program that has all of them at once.
#ifndef OPENNTC_TESTS_HOST_MACROS_H
#define OPENNTC_TESTS_HOST_MACROS_H

// As X11/X.h and X11/Xlib.h spell them.
#define Status int
#define Bool int
#define None 0L
#define True 1
#define False 0
#define Success 0
#define Always 2
#define TileShape 1

// As the Windows SDK does without NOMINMAX and WIN32_LEAN_AND_MEAN.
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))
#define near
#define far
#define small char
#define interface struct
#define pascal
#define cdecl
#define IN
#define OUT
#define OPTIONAL
#define CONST const
#define VOID void
#define TRUE 1
#define FALSE 0
#define STRICT 1
#define ERROR 0
#define NO_ERROR 0L
#define DELETE (0x00010000L)
#define OPAQUE 2
#define TRANSPARENT 1
#define RELATIVE 2
#define ABSOLUTE 1
#define DOMAIN 1
#define OVERFLOW 3
#define UNDERFLOW 4
#define GetObject GetObjectA
#define GetMessage GetMessageA
#define LoadImage LoadImageA
#define CreateFile CreateFileA
#define Yield()

// Of small boards, engines and test frameworks.
#define abs(x) ((x) > 0 ? (x) : -(x))
#define round(x) ((x) >= 0 ? static_cast<long>((x) + 0.5) : static_cast<long>((x)-0.5))
#define F(x) x
#define PI 3.14159
#define nil nullptr
#define check(x) static_cast<void>(0)
#define verify(x) static_cast<void>(0)
#define require(x) static_cast<void>(0)
#define ensure(x) (x)
#define LOG(x)
#define CHECK(x)
#define DEBUG 1
#define RELEASE 0
#define ENABLED 1
#define unix 1
#define linux 1

#endif
