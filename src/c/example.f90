! The length of an AXIAL stretched by a half, and its row.
program example
  use pintle
  implicit none
  type(c_ptr) :: spring
  type(pintle_pair) :: pair
  real(c_double) :: values(6), rows(14, 6), d(3), length
  spring = pintle_open("AXIAL")
  if (.not. c_associated(spring)) stop 1
  if (pintle_initial(spring, pair) /= 0) stop 2
  d = pair%x(:, 2) - pair%x(:, 1)
  length = sqrt(dot_product(d, d))
  pair%x(:, 2) = pair%x(:, 1) + 1.5d0 * d
  if (pintle_evaluate(spring, pair, values, rows) /= 0) stop 3
  print "(a, f18.15)", "u1 over length", values(1) / length
  print "(a, f18.15)", "row along d", dot_product(rows(8:10, 1), d) / length
  call pintle_close(spring)
end program
