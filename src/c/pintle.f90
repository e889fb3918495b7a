! pintle for Fortran: the functions of pintle.h.
!
!     gfortran -o program pintle.f90 program.f90 -Ltarget/release -lpintle_c
!
! Arrays are those of C with their indices reversed: rows(14, 6), triad(3, 3, 2), so that rows(:, k) is the row of component k.
module pintle
  use, intrinsic :: iso_c_binding
  implicit none

  type, bind(c) :: pintle_pair
    real(c_double) :: x(3, 2)
    real(c_double) :: triad(3, 3, 2)
    real(c_double) :: flow(2)
    real(c_double) :: velocity(14)
    real(c_double) :: acceleration(14)
  end type

  interface
    function pintle_open_c(name) bind(c, name="pintle_open") result(connector)
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr) :: connector
    end function
    subroutine pintle_close(connector) bind(c)
      import :: c_ptr
      type(c_ptr), value :: connector
    end subroutine
    function pintle_initial(connector, pair) bind(c) result(code)
      import :: c_ptr, c_int, pintle_pair
      type(c_ptr), value :: connector
      type(pintle_pair), intent(out) :: pair
      integer(c_int) :: code
    end function
    function pintle_kinds(connector, kinds) bind(c) result(code)
      import :: c_ptr, c_int
      type(c_ptr), value :: connector
      integer(c_int), intent(out) :: kinds(6)
      integer(c_int) :: code
    end function
    function pintle_evaluate(connector, pair, values, rows) bind(c) result(code)
      import :: c_ptr, c_int, c_double, pintle_pair
      type(c_ptr), value :: connector
      type(pintle_pair), intent(in) :: pair
      real(c_double), intent(out) :: values(6)
      real(c_double), intent(out) :: rows(14, 6)
      integer(c_int) :: code
    end function
    function pintle_rates(connector, pair, rates, accelerations) bind(c) result(code)
      import :: c_ptr, c_int, c_double, pintle_pair
      type(c_ptr), value :: connector
      type(pintle_pair), intent(in) :: pair
      real(c_double), intent(out) :: rates(6), accelerations(6)
      integer(c_int) :: code
    end function
    function pintle_second_derivatives(connector, pair, second) bind(c) result(code)
      import :: c_ptr, c_int, c_double, pintle_pair
      type(c_ptr), value :: connector
      type(pintle_pair), intent(in) :: pair
      real(c_double), intent(out) :: second(14, 14, 6)
      integer(c_int) :: code
    end function
    function pintle_commit(connector, pair) bind(c) result(code)
      import :: c_ptr, c_int, pintle_pair
      type(c_ptr), value :: connector
      type(pintle_pair), intent(in) :: pair
      integer(c_int) :: code
    end function
    function pintle_reset(connector) bind(c) result(code)
      import :: c_ptr, c_int
      type(c_ptr), value :: connector
      integer(c_int) :: code
    end function
  end interface

contains

  function pintle_open(name) result(connector)
    character(*), intent(in) :: name
    type(c_ptr) :: connector
    connector = pintle_open_c(trim(name) // c_null_char)
  end function
end module
