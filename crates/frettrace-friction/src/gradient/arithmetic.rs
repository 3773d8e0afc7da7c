//! The operators.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use super::Gradient;

impl<const K: usize> Gradient<K> {
    /// A function of two numbers from its value and its two partial derivatives.
    #[inline(always)]
    fn join(self, other: Self, value: f64, [by_self, by_other]: [f64; 2]) -> Self {
        let mut slopes = [0.0; K];
        for (index, slope) in slopes.iter_mut().enumerate() {
            *slope = self.slopes[index] * by_self + other.slopes[index] * by_other;
        }
        Self { re: value, slopes }
    }
}

impl<const K: usize> Add for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.join(other, self.re + other.re, [1.0, 1.0])
    }
}

impl<const K: usize> Sub for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.join(other, self.re - other.re, [1.0, -1.0])
    }
}

impl<const K: usize> Mul for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.join(other, self.re * other.re, [other.re, self.re])
    }
}

impl<const K: usize> Div for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = other.re.recip();
        let value = self.re * inverse;
        self.join(other, value, [inverse, -value * inverse])
    }
}

impl<const K: usize> Rem for Gradient<K> {
    type Output = Self;
    fn rem(self, other: Self) -> Self {
        self.join(other, self.re % other.re, [1.0, -(self.re / other.re).trunc()])
    }
}

impl<const K: usize> Neg for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.re, -1.0)
    }
}

impl<const K: usize> Add<f64> for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self { re: self.re + other, ..self }
    }
}

impl<const K: usize> Sub<f64> for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self { re: self.re - other, ..self }
    }
}

impl<const K: usize> Mul<f64> for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.re * other, other)
    }
}

impl<const K: usize> Div<f64> for Gradient<K> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self.chain(self.re / other, other.recip())
    }
}

impl<const K: usize> Rem<f64> for Gradient<K> {
    type Output = Self;
    fn rem(self, other: f64) -> Self {
        Self { re: self.re % other, ..self }
    }
}

/// The forms by reference and with assignment, from the one by value.
macro_rules! other_forms {
    ($operator:ident $method:ident $assign:ident $assign_method:ident $symbol:tt) => {
        impl<'a, const K: usize> $operator<&'a Gradient<K>> for Gradient<K> {
            type Output = Gradient<K>;
            #[inline(always)]
            fn $method(self, other: &'a Gradient<K>) -> Gradient<K> {
                self $symbol *other
            }
        }
        impl<const K: usize> $assign for Gradient<K> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = *self $symbol other;
            }
        }
        impl<const K: usize> $assign<f64> for Gradient<K> {
            #[inline(always)]
            fn $assign_method(&mut self, other: f64) {
                *self = *self $symbol other;
            }
        }
    };
}

other_forms!(Add add AddAssign add_assign +);
other_forms!(Sub sub SubAssign sub_assign -);
other_forms!(Mul mul MulAssign mul_assign *);
other_forms!(Div div DivAssign div_assign /);
other_forms!(Rem rem RemAssign rem_assign %);
