// MPM_MULTIVERSION before a function: it is compiled for several x86-64 levels, and the loader takes the best that the processor has.
// Only such functions carry newer instructions, so the program starts on every host.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(MATPOINT_NO_MULTIVERSION)
#define MPM_MULTIVERSION __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MPM_MULTIVERSION
#endif
