"""Exact zero tests for scripts/proof/prove.py: polynomials over the rationals (SymPy's rings), modulo the relations of angles and roots.

A number is a fraction of polynomials in plain symbols, in angles, and in the cosine and sine of each angle, with sin² = 1 − cos².
Square roots that are no such fraction are adjoined with their relation. In this ring, which has no zero divisors, a fraction is zero
exactly if its reduced numerator is: that is a proof, not a sample.

What an arctangent, an arc cosine or the sign of a root is depends on the region. Each number therefore also carries its value to 110
digits at one sample point, computed apart from the fraction: it decides branches and signs, and it is the fallback where the
fraction cannot be had.
"""

import itertools

import mpmath
import sympy
from sympy.polys.rings import ring

DIGITS = 110
mpmath.mp.dps = DIGITS
NOISE = mpmath.mpf(10) ** -50
"""Values that agree to this, relative to their size, agree to 50 digits."""

ROOTS = 8
"""How many square roots can be adjoined, and how many exponentials."""

LARGE = 60
"""The most terms of a numerator for which common factors are looked for; without them a fraction is only longer."""


class NotExact(Exception):
    """The fraction is not to be had: sampling decides."""


class Ring:
    """Q[symbols, angles, cosines, sines, π, roots] modulo the relations, at one sample point."""

    def __init__(self, symbols, angles):
        """`symbols` and `angles` map names to their values at the sample point."""
        self.values = {}
        names = list(symbols)
        for name in angles:
            names += [name, f"cos_{name}", f"sin_{name}"]
        names += ["pi"] + [f"root{i}" for i in range(ROOTS)] + [f"exponential{i}" for i in range(ROOTS)]
        self.names = names
        self.ring, *generators = ring(names, sympy.QQ)
        self.generator = dict(zip(names, generators))
        self.place = {name: i for i, name in enumerate(names)}
        self.relations = []
        self.angles = list(angles)
        point = {name: mpmath.mpmathify(value) for name, value in symbols.items()}
        point["pi"] = mpmath.pi
        for name, value in angles.items():
            value = mpmath.mpmathify(value)
            point |= {name: value, f"cos_{name}": mpmath.cos(value), f"sin_{name}": mpmath.sin(value)}
            cosine = self.generator[f"cos_{name}"]
            self.relations.append((self.place[f"sin_{name}"], 1 - cosine**2))
        self.point = point
        self.roots, self.exponentials = [], []
        self.squares = {}
        for names in itertools.chain(itertools.combinations(self.angles, 1), itertools.combinations(self.angles, 2)):
            for powers in itertools.product((1, 2), repeat=len(names)):
                form = self.ring(1)
                for name, power in zip(names, powers):
                    form *= (1 - self.generator[f"cos_{name}"] ** 2) ** power
                self.squares[form.monic()] = {f"sin_{name}": 2 * power for name, power in zip(names, powers)}

    def reduced(self, polynomial):
        """The normal form: at most the first power of each sine and root."""
        for place, square in reversed(self.relations):
            if not any(monomial[place] > 1 for monomial in polynomial):
                continue
            parts = {}
            for monomial, coefficient in polynomial.items():
                half, odd = divmod(monomial[place], 2)
                rest = monomial[:place] + (odd,) + monomial[place + 1 :]
                parts.setdefault(half, {})[rest] = coefficient
            polynomial = self.ring(0)
            for half, terms in parts.items():
                polynomial += self.ring.from_dict(terms) * square**half
        return polynomial

    def value_of(self, polynomial):
        total = mpmath.mpf(0)
        for monomial, coefficient in polynomial.items():
            term = mpmath.mpf(int(coefficient.numerator)) / int(coefficient.denominator)
            for name, power in zip(self.names, monomial):
                if power:
                    term *= self.point[name] ** power
            total += term
        return total

    def factors_of(self, polynomial):
        """A polynomial as a constant times powers of known factors."""
        constant, factors = sympy.QQ(1), {}
        least = [min(powers) for powers in zip(*polynomial)]
        for place, power in enumerate(least):
            if power:
                factors[self.ring.gens[place]] = power
        rest = polynomial.quo(self.ring.from_dict({tuple(least): sympy.QQ(1)})) if any(least) else polynomial
        if rest.is_ground:
            return rest.LC, factors
        known = self.squares.get(rest.monic())
        if known is not None:
            constant = rest.LC / rest.monic().LC
            for name, power in known.items():
                generator = self.generator[name]
                factors[generator] = factors.get(generator, 0) + power
            # The monic form is that of Π (1 − cos²) up to its sign.
            form = self.ring(1)
            for name, power in known.items():
                form *= (1 - self.generator["cos_" + name[4:]] ** 2) ** (power // 2)
            return rest.LC / form.LC, factors
        monic = rest.monic()
        factors[monic] = factors.get(monic, 0) + 1
        return constant * rest.LC, factors

    def root(self, number):
        """√ of a fraction: a fraction where it is one, else an adjoined root."""
        if number.is_zero():
            return number
        inside, outside = number.numerator, self.constant(1)
        for factor, power in number.denominator.items():
            if power % 2:
                inside = self.reduced(inside * factor)
            outside = outside / Fraction(self, factor, {}) ** ((power + 1) // 2)
        constant, parts = inside.factor_list()
        odd = self.ring(1)
        for factor, power in parts:
            outside = outside * Fraction(self, factor ** (power // 2), {})
            if power % 2:
                odd *= factor
        more, factors = self.factors_of(odd)
        constant *= more
        rest = self.ring(1)
        root_of_constant = sympy.sqrt(sympy.Rational(int(constant.numerator), int(constant.denominator)))
        if root_of_constant.is_Rational:
            outside = outside * self.constant(root_of_constant)
        else:
            rest *= constant
        for factor, power in factors.items():
            half, left = divmod(power, 2)
            if half:
                outside = outside * Fraction(self, factor**half, {})
            if left:
                rest *= factor
        rest = self.reduced(rest)
        if rest != 1:
            outside = outside * Fraction(self, self.adjoined(rest), {})
        return -outside if outside.value() < 0 else outside

    def adjoined(self, polynomial):
        for known, generator in self.roots:
            if known == polynomial:
                return generator
        if len(self.roots) == ROOTS:
            raise NotExact("too many roots")
        name = f"root{len(self.roots)}"
        generator = self.generator[name]
        value = self.value_of(polynomial)
        if value < 0:
            raise NotExact("root of a negative number")
        self.point[name] = mpmath.sqrt(value)
        self.roots.append((polynomial, generator))
        self.relations.append((self.place[name], polynomial))
        return generator

    def exponential(self, exponent):
        """eˣ, the same symbol for the same x."""
        for known, generator in self.exponentials:
            if (known - exponent).is_zero():
                return Fraction(self, generator, {})
        if len(self.exponentials) == ROOTS:
            raise NotExact("too many exponentials")
        name = f"exponential{len(self.exponentials)}"
        self.point[name] = mpmath.exp(exponent.value())
        self.exponentials.append((exponent, self.generator[name]))
        return self.named(name)

    def constant(self, value):
        value = sympy.Rational(value)
        return Fraction(self, self.ring(sympy.QQ(int(value.p), int(value.q))), {})

    def named(self, name):
        return Fraction(self, self.generator[name], {})

    def cosine_sine(self, angle):
        """Of a whole linear combination of the angles and of π/2."""
        if angle.denominator:
            raise NotExact("cosine of a fraction")
        cosine, sine = self.constant(1), self.constant(0)
        for monomial, coefficient in angle.numerator.items():
            name = self.names[monomial.index(1)] if sum(monomial) == 1 else None
            if name == "pi":
                quarters = coefficient * 2
                if quarters.denominator != 1:
                    raise NotExact("cosine of a part of π")
                c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][int(quarters) % 4]
                c, s = self.constant(c), self.constant(s)
            elif name in self.angles and coefficient.denominator == 1:
                c, s = self.constant(1), self.constant(0)
                one = self.named(f"cos_{name}"), self.named(f"sin_{name}")
                for _ in range(abs(int(coefficient))):
                    c, s = c * one[0] - s * one[1], s * one[0] + c * one[1]
                if coefficient < 0:
                    s = -s
            else:
                raise NotExact("cosine of no angle")
            cosine, sine = cosine * c - sine * s, sine * c + cosine * s
        return cosine, sine

    def angle(self, y, x, value, candidates):
        """The angle of the point (x, y), if it is one of the candidates but for half turns."""
        for candidate in itertools.chain(candidates, (-candidate for candidate in candidates)):
            cosine, sine = self.cosine_sine(candidate)
            if (y * cosine - x * sine).is_zero():
                turns = (value - candidate.value()) / mpmath.pi
                whole = int(mpmath.nint(turns))
                if abs(turns - whole) > NOISE:
                    raise NotExact("an arctangent off its branch")
                return candidate + self.constant(whole) * self.named("pi")
        raise NotExact("an arctangent that is no angle of the parametrization")


class Fraction:
    """A numerator over powers of polynomials."""

    __slots__ = ("ring", "numerator", "denominator")

    def __init__(self, ring_, numerator, denominator):
        self.ring, self.numerator, self.denominator = ring_, numerator, denominator

    def is_zero(self):
        return not self.numerator

    def value(self):
        value = self.ring.value_of(self.numerator)
        for factor, power in self.denominator.items():
            value /= self.ring.value_of(factor) ** power
        return value

    def _cancelled(self, numerator, denominator):
        if not numerator:
            return Fraction(self.ring, numerator, {})
        kept = {}
        for factor, power in denominator.items():
            if len(factor) == 1:
                place = next(place for place, exponent in enumerate(factor.LM) if exponent)
                shared = min(power, min(monomial[place] for monomial in numerator))
                if shared:
                    numerator, power = numerator.quo(factor**shared), power - shared
            while power and len(factor) > 1 and len(numerator) <= LARGE:
                quotient, rest = numerator.div(factor)
                if rest:
                    break
                numerator, power = quotient, power - 1
            if power:
                kept[factor] = power
        return Fraction(self.ring, numerator, kept)

    def __add__(self, other):
        if self.is_zero():
            return other
        if other.is_zero():
            return self
        denominator = dict(self.denominator)
        for factor, power in other.denominator.items():
            denominator[factor] = max(power, denominator.get(factor, 0))
        total = self.ring.ring(0)
        for part in (self, other):
            term = part.numerator
            for factor, power in denominator.items():
                missing = power - part.denominator.get(factor, 0)
                if missing:
                    term = self.ring.reduced(term * factor**missing)
            total += term
        return self._cancelled(total, denominator)

    def __neg__(self):
        return Fraction(self.ring, -self.numerator, self.denominator)

    def __sub__(self, other):
        return self + (-other)

    def __mul__(self, other):
        denominator = dict(self.denominator)
        for factor, power in other.denominator.items():
            denominator[factor] = power + denominator.get(factor, 0)
        return self._cancelled(self.ring.reduced(self.numerator * other.numerator), denominator)

    def inverse(self):
        if self.is_zero():
            raise NotExact("division by zero")
        constant, factors = self.ring.factors_of(self.numerator)
        numerator = self.ring.ring(1 / constant)
        for factor, power in self.denominator.items():
            numerator = self.ring.reduced(numerator * factor**power)
        return self._cancelled(numerator, factors)

    def __truediv__(self, other):
        return self * other.inverse()

    def __pow__(self, power):
        result = self.ring.constant(1)
        base = self if power >= 0 else self.inverse()
        for _ in range(abs(power)):
            result = result * base
        return result


class Number:
    """A value to 110 digits, and the fraction that it is, or None with the reason why there is none."""

    __slots__ = ("value", "fraction", "reason")

    def __init__(self, value, fraction, reason=None):
        self.value, self.fraction, self.reason = value, fraction, reason

    def __neg__(self):
        return Number(-self.value, None if self.fraction is None else -self.fraction, self.reason)

    def __add__(self, other):
        if self.fraction is None or other.fraction is None:
            return Number(self.value + other.value, None, self.reason or other.reason)
        return Number(self.value + other.value, self.fraction + other.fraction)

    def __sub__(self, other):
        return self + (-other)

    def is_near_zero(self, size):
        """To 50 digits of `size`."""
        return abs(self.value) <= NOISE * (1 + abs(size))


def relations_of(condition):
    """The comparisons in a condition."""
    if isinstance(condition, sympy.core.relational.Relational):
        return [condition]
    return [relation for part in condition.args for relation in relations_of(part)]


class Evaluation:
    """SymPy expressions as numbers, at the sample point of a ring and in a neighbourhood of it."""

    def __init__(self, ring_, numbers, angles=(), exact=True):
        """`numbers` maps symbols to fractions or values; `angles` lists what arctangents may be. Not `exact`: values only."""
        self.ring = ring_
        self.candidates = list(angles)
        self.known = {}
        for symbol, number in numbers.items():
            is_fraction = isinstance(number, Fraction)
            value = number.value() if is_fraction else number
            self.known[symbol] = Number(value, number if exact and is_fraction else None, "sampled")
        self.branches = set()
        """The conditions that held, with what they decided."""

    def of(self, expression):
        expression = sympy.sympify(expression)
        pending = [expression]
        while pending:
            current = pending[-1]
            if current in self.known:
                pending.pop()
                continue
            if isinstance(current, sympy.Piecewise):
                chosen = self._chosen(current, pending)
                if chosen is None:
                    continue
                self.known[current] = self.known[chosen]
                pending.pop()
                continue
            missing = [argument for argument in current.args if argument not in self.known]
            if missing:
                pending += missing
                continue
            self.known[current] = self._number(current, [self.known[argument] for argument in current.args])
            pending.pop()
        return self.known[expression]

    def _chosen(self, piecewise, pending):
        """The expression of the first condition that holds, once all that decides it is known."""
        for expression, condition in piecewise.args:
            missing = [side for relation in relations_of(condition) for side in relation.args if side not in self.known]
            if missing:
                pending += missing
                return None
            if not self._holds(condition):
                continue
            if expression not in self.known:
                pending.append(expression)
                return None
            self.branches.add((piecewise, condition))
            return expression
        raise ValueError("no condition of a Piecewise holds")

    def _holds(self, condition):
        if condition in (sympy.true, sympy.false):
            return condition == sympy.true
        if isinstance(condition, sympy.And):
            return all(self._holds(part) for part in condition.args)
        if isinstance(condition, sympy.Or):
            return any(self._holds(part) for part in condition.args)
        if isinstance(condition, sympy.ITE):
            decides, yes, no = condition.args
            return self._holds(yes if self._holds(decides) else no)
        if isinstance(condition, sympy.Not):
            return not self._holds(condition.args[0])
        left, right = (self.known[side].value for side in condition.args)
        return {
            sympy.StrictLessThan: left < right,
            sympy.StrictGreaterThan: left > right,
            sympy.LessThan: left <= right,
            sympy.GreaterThan: left >= right,
            sympy.Equality: left == right,
            sympy.Unequality: left != right,
        }[type(condition)]

    def _number(self, expression, arguments):
        values = [argument.value for argument in arguments]
        value = self._value(expression, values)
        reasons = [argument.reason for argument in arguments if argument.fraction is None]
        if reasons:
            return Number(value, None, reasons[0])
        try:
            return Number(value, self._fraction(expression, [argument.fraction for argument in arguments], value))
        except NotExact as reason:
            return Number(value, None, str(reason))

    def _value(self, expression, values):
        head = expression.func
        if expression.is_Rational:
            return mpmath.mpf(int(expression.p)) / int(expression.q)
        if expression is sympy.pi:
            return mpmath.pi + 0
        if expression.is_Add:
            return mpmath.fsum(values)
        if expression.is_Mul:
            return mpmath.fprod(values)
        if expression.is_Pow:
            return values[0] ** values[1]
        functions = {
            sympy.atan2: mpmath.atan2, sympy.atan: mpmath.atan, sympy.acos: mpmath.acos, sympy.asin: mpmath.asin,
            sympy.sin: mpmath.sin, sympy.cos: mpmath.cos, sympy.tan: mpmath.tan, sympy.exp: mpmath.exp,
            sympy.Abs: abs, sympy.sign: mpmath.sign, sympy.floor: mpmath.floor, sympy.log: mpmath.log,
            sympy.Min: min, sympy.Max: max,
        }
        if head in functions:
            if head in (sympy.Min, sympy.Max):
                return functions[head](values)
            return functions[head](*values)
        raise ValueError(f"{head} is not known to the proofs")

    def _fraction(self, expression, fractions, value):
        head, ring_ = expression.func, self.ring
        if expression.is_Rational:
            return ring_.constant(expression)
        if expression is sympy.pi:
            return ring_.named("pi")
        if expression.is_Add:
            total = ring_.constant(0)
            for fraction in fractions:
                total = total + fraction
            return total
        if expression.is_Mul:
            product = ring_.constant(1)
            for fraction in fractions:
                product = product * fraction
            return product
        if expression.is_Pow:
            power = expression.exp
            if power.is_Integer:
                return fractions[0] ** int(power)
            if power.is_Rational and power.q in (2, 4):
                base = ring_.root(fractions[0])
                return (base if power.q == 2 else ring_.root(base)) ** int(power.p)
        if head is sympy.Abs:
            return -fractions[0] if fractions[0].value() < 0 else fractions[0]
        if head is sympy.sign:
            return ring_.constant(int(mpmath.sign(value)))
        if head is sympy.floor:
            return ring_.constant(int(value))
        if head is sympy.exp:
            return ring_.exponential(fractions[0])
        if head is sympy.sin:
            return ring_.cosine_sine(fractions[0])[1]
        if head is sympy.cos:
            return ring_.cosine_sine(fractions[0])[0]
        if head is sympy.tan:
            cosine, sine = ring_.cosine_sine(fractions[0])
            return sine / cosine
        if head is sympy.atan2:
            return ring_.angle(*fractions, value, self.candidates)
        if head is sympy.atan:
            return ring_.angle(fractions[0], ring_.constant(1), value, self.candidates)
        if head is sympy.acos:
            across = ring_.root(ring_.constant(1) - fractions[0] * fractions[0])
            return ring_.angle(across, fractions[0], value, self.candidates)
        if head is sympy.asin:
            across = ring_.root(ring_.constant(1) - fractions[0] * fractions[0])
            return ring_.angle(fractions[0], across, value, self.candidates)
        if head in (sympy.Min, sympy.Max):
            return next(f for f in fractions if abs(f.value() - value) <= NOISE * (1 + abs(value)))
        raise NotExact(f"{expression.func.__name__} of {expression.args[1:]} in closed form")
