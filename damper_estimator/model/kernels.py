"""Calls of kernels and loops from compiled code, by the address of their machine code.

A function called by its address is compiled once for all callers; a direct call would copy it into each caller.
"""

from collections.abc import Callable

import numpy as np

from damper_estimator.compiled import COMPILED

BLOCK_LOOP, SAMPLE_LOOP, FIRST_KERNEL = range(3)
"""Places in the list of a program's functions: the loop over operations on blocks, that over samples with a series (0
without series), and the kernels in order.
"""

if COMPILED:
    from numba import float64, int64, intp, types
    from numba.core import cgutils
    from numba.extending import intrinsic
    from numba.np.arrayobj import populate_array

    _VECTOR, _MATRIX, _STACK = float64[::1], float64[:, ::1], float64[:, :, ::1]
    KERNEL = types.void(_VECTOR, _VECTOR, _MATRIX, _VECTOR, _VECTOR)
    """Signature of a kernel: parameters, settings, kinematics, state, force."""
    LOOP = types.void(int64[::1], int64[:, ::1], _VECTOR, _VECTOR, _MATRIX, _STACK, _MATRIX, _VECTOR, _MATRIX, _MATRIX)
    """Signature of a loop; see ``chain.run``."""

    def _call(context, builder, signature, address, arguments):
        """Calls the function at an address by numba's convention; exceptions propagate to the caller."""
        kinds = signature.args
        code = context.call_conv.get_function_type(signature.return_type, kinds)
        pointer = builder.inttoptr(address, code.as_pointer())
        status, _ = context.call_conv.call_function(builder, pointer, signature.return_type, kinds, arguments)
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return context.get_dummy_value()

    @intrinsic
    def call_kernel(typing, functions, number, parameters, settings, kinematics, state, force):
        """Calls a kernel by its position in the list of functions."""

        def code(context, builder, signature, arguments):
            listed = context.make_array(signature.args[0])(context, builder, arguments[0])
            place = builder.add(arguments[1], context.get_constant(int64, FIRST_KERNEL))
            address = builder.load(builder.gep(listed.data, [place]))
            return _call(context, builder, KERNEL, address, arguments[2:])

        return types.void(int64[::1], int64, *KERNEL.args), code

    def by_address(function: Callable, number: int) -> Callable:
        """The loop ``number`` for calls from compiled code."""

        @intrinsic
        def call_loop(
            typing, functions, table, parameters, settings, kinematics, motions, forces, state, solvers, trace
        ):
            def code(context, builder, signature, arguments):
                listed = context.make_array(signature.args[0])(context, builder, arguments[0])
                address = builder.load(builder.gep(listed.data, [context.get_constant(int64, number)]))
                return _call(context, builder, LOOP, address, arguments)

            return LOOP, code

        call_loop.py_func = function.py_func
        return call_loop

    @intrinsic
    def part(typing, array, first, last):
        """``array[first:last]`` for valid indices; a view that does not keep the array alive."""

        def code(context, builder, signature, arguments):
            kind = signature.args[0]
            whole = context.make_array(kind)(context, builder, arguments[0])
            view = context.make_array(kind)(context, builder)
            populate_array(
                view,
                data=builder.gep(whole.data, [arguments[1]]),
                shape=cgutils.pack_array(builder, [builder.sub(arguments[2], arguments[1])]),
                strides=whole.strides,
                itemsize=whole.itemsize,
                meminfo=None,
            )
            return view._getvalue()

        return array(array, intp, intp), code

else:

    def call_kernel(functions, number, parameters, settings, kinematics, state, force):
        """Calls a kernel by its position in the list of functions."""
        functions[FIRST_KERNEL + number](parameters, settings, kinematics, state, force)

    def by_address(function: Callable, number: int) -> Callable:
        """The loop itself."""
        return function

    def part(array, first, last):
        """``array[first:last]``"""
        return array[first:last]


def addresses(loops: list, kernels: list) -> np.ndarray | list:
    """The functions of a program for the loops: their addresses, or the functions themselves without compilation.

    Args:
        loops: two; the second may be None.
        kernels: any number.
    """
    if not COMPILED:
        return [*loops, *kernels]
    return np.array(
        [0 if loop is None else _address(loop, LOOP) for loop in loops]
        + [_address(kernel, KERNEL) for kernel in kernels]
    )


def _address(function, signature) -> int:
    function.compile(signature)
    made = function.overloads[signature.args]
    return made.library.get_pointer_to_function(made.fndesc.llvm_func_name)
